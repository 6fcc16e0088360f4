#pragma once

#include "erc_state.h"

/* The field at which the model gives a torque at rest, the nearest to zero, and the model's flags. Without a model it is
 * zero. */
uint32_t erc_inverse(const erc_core *core, const double *in, double wanted, double *field);
/* The model's torque at rest under a signed field; not a number where the model cannot say. */
double erc_at_rest(const erc_core *core, const double *in, double field);
