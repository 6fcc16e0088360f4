#pragma once

#include "erc_state.h"

/* Whether a reading of the torque sensor can be. Returns its events and keeps in core->meter what follows from it. */
uint32_t erc_torque_plausible(erc_core *core, double torque);

/* Once a period, before its samples: what the model expects of the torque sensor. */
void erc_torque_expect(erc_core *core, uint32_t periods);

/* Share of a command that is left after periods with a wrong sensor: all, then less and less, then none some periods
 * before the trip. */
double erc_held_share(uint32_t hold, uint32_t trip, uint32_t periods);

double erc_at_most(double x, double most);

/* Whether the clutch under field slips, so that the sign and size of its torque are known. */
bool erc_slipping(const erc_core *core);
