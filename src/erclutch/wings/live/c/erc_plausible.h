#pragma once

#include "erc_state.h"

/* Whether a reading of the torque sensor can be. Returns its events and keeps in core->meter what follows from it. */
uint32_t erc_torque_plausible(erc_core *core, double torque);

/* Once a period, before its samples: what the model expects of the torque sensor. */
void erc_torque_expect(erc_core *core, uint32_t periods);

/* Once a period, after the model's step: whether it was outside its log. */
void erc_torque_guess(erc_core *core, bool outside);

/* After the samples of a period: whether the measured torque and the motion of the output fit together, or of the drive of
 * a single device, where config says that they have to. Returns the events. */
uint32_t erc_momentum_plausible(erc_core *core);

/* Its events where they do not: of meter and encoder one is wrong. */
uint32_t erc_momentum_doubts(const erc_core *core);

/* For how many periods they have disagreed, as they count for the command: nothing takes a sure doubt back, so no command
 * is held for it. */
uint32_t erc_momentum_periods(const erc_core *core, uint32_t hold);

/* Share of a command that is left after periods with a wrong sensor: all, then less and less, then none some periods
 * before the trip. */
double erc_held_share(uint32_t hold, uint32_t trip, uint32_t periods);

double erc_at_most(double x, double most);
