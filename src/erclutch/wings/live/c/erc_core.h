/* One control step without any input or output: samples in, command and frame out. The loop calls it each millisecond;
 * tests and accelerated runs call the same code from Python. */
#pragma once

#include "erc_state.h"

void erc_core_init(erc_core *core, const erc_config *config, const erc_row *table, const erc_model *model);

/* Checks an order and carries it out; 1 if the loop is to end. */
int erc_core_order(erc_core *core, const erc_order *order);

/* From now on fields and motor torque are zero. */
void erc_core_stop(erc_core *core);

/* One step.
 * samples: what came in since the last step, in order of arrival. tick: number of the deadline. late_ns: wake-up after
 * it. events: what input and output already saw. */
void erc_core_step(erc_core *core, const erc_sample *samples, uint32_t count, uint64_t tick, uint64_t late_ns,
                   uint32_t events, erc_command *command, erc_frame *frame);

/* Sizes and the state for callers that only see bytes. */
uint32_t erc_core_state(const erc_core *core);
uint32_t erc_core_size(void);
uint32_t erc_core_config_size(void);
