#pragma once

#include "erc_state.h"

/* Forget what the stages have learned: a program begins. */
void erc_torque_start(erc_core *core);
/* Signed field for a wanted torque [N*m] that changes at a rate [N*m/s]. */
double erc_torque_field(erc_core *core, double wanted, double rate, uint32_t *events);
