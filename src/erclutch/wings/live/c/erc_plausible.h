#pragma once

#include "erc_state.h"

/* Whether a reading of the torque sensor can be. Returns its events and keeps in core->meter what follows from it. */
uint32_t erc_torque_plausible(erc_core *core, double torque);

/* Once a period, before its samples: what the model expects of the torque sensor. */
void erc_torque_expect(erc_core *core, uint32_t periods);

/* Once a period, after the model's step: whether it was outside its log. */
void erc_torque_guess(erc_core *core, bool outside);

/* After the samples of a period: whether the measured torque and the output's motion fit together, where config says that
 * they have to; `placed`: the output is within its stroke, where no end stop acts on it. Returns the events. */
uint32_t erc_momentum_plausible(erc_core *core, bool placed);

/* Share of a command that is left after periods with a wrong sensor: all, then less and less, then none some periods
 * before the trip. */
double erc_held_share(uint32_t hold, uint32_t trip, uint32_t periods);

double erc_at_most(double x, double most);

/* Whether the clutch under field slips, so that the sign and size of its torque are known. */
bool erc_slipping(const erc_core *core);
