#pragma once

#include "erc_layout.h"

/* What of `ask` may go out, and the events. previous: the signed field of the step before. */
uint32_t erc_interlock(const erc_config *config, double previous, double alpha, double theta_dot, const double ask[3],
                       double out[3]);
