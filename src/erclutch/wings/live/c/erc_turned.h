#pragma once

#include "erc_state.h"

/* For each reading of the torque sensor that can be: whether the last ones are those of a sensor that was turned, or that
 * reads another torque than before while a load rests. withstands: the torque in N m that the load's dry
 * friction holds; 0: the load moves, or nobody knows. slips: so that field and slip tell the torque. In core->meter.turn
 * it says whether the torque has stepped without them. */
bool erc_torque_changed(erc_core *core, double torque, double withstands, bool slips);

/* Keeps the model's torque as late as the meter's of the last periods, and by how much it has moved in them, now included:
 * a rotor rings on its torque meter by no more. Of a step, the meter may read more than shows yet. */
void erc_torque_keep(erc_meter *m, double now);

/* Whether the speeds are in time: behind a slow filter a clutch may have locked while it still seems to slip. */
bool erc_speeds_in_time(const erc_core *core);

/* Whether the clutch under field slips, so that the sign and size of its torque are known. */
bool erc_slipping(const erc_core *core);

/* Whether the output is within its stroke, where no end stop acts on it. */
bool erc_placed(const erc_core *core);
