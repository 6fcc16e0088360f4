#pragma once

#include "erc_state.h"

/* For each reading of the torque sensor that can be: whether the last ones are those of a sensor that was turned. */
bool erc_torque_turned(erc_core *core, double torque);
