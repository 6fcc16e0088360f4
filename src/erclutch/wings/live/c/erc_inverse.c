/* The compiled model, asked for a field or for a torque at rest. */
#include "erc_inverse.h"

#include <math.h>

uint32_t erc_inverse(const erc_core *core, const double *in, double wanted, double *field) {
    *field = 0.0;
    return core->model.inverse == 0 ? 0u : core->model.inverse(in, wanted, field);
}

double erc_at_rest(const erc_core *core, const double *in, double field) {
    const double coaxial[5] = {field > 0.0 ? field : 0.0, field < 0.0 ? -field : 0.0, in[2], in[3], 0.0};
    const double single[3] = {field > 0.0 ? field : 0.0, in[1], 0.0};
    double torque = (double)NAN;
    if (core->model.steady != 0) {
        (void)core->model.steady(core->config.device == ERC_SINGLE ? single : coaxial, &torque);
    }
    return torque;
}
