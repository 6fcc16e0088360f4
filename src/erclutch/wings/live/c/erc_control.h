#pragma once

#include "erc_state.h"

void erc_control_start(erc_core *core, uint32_t program, uint64_t tick);
/* What the running program asks for: two fields and the motor torque. Returns events. */
uint32_t erc_control(erc_core *core, uint64_t tick, double ask[3]);
