#pragma once

#include "erc_state.h"

/* Takes the samples of a step and returns its events. periods: since the last step, more than one after an overrun. */
uint32_t erc_sensors_take(erc_core *core, const erc_sample *samples, uint32_t count, uint64_t periods);
