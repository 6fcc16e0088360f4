/* For Frama-C's Eva: the plausibility of a torque sensor in a loop of unknown length, fed with any bits, as the core calls
 * it; and what is left of a command by it. */
#include "erc_plausible.h"

#include "__fc_builtin.h"
#include <float.h>
#include <math.h>
#include <string.h>

#define LIMIT 2.0

volatile uint64_t source;

static double any(void) {
    double x;
    uint64_t bits = source;
    memcpy(&x, &bits, sizeof x);
    return x;
}

int main(void) {
    static erc_core core;
    /* What erc_config_error() lets through. */
    core.dt = Frama_C_double_interval(1e-4, 1.0);
    core.config.torque_limit = LIMIT;
    while (source) {
        int within;
        uint32_t wrong;
        double asked, share, most = Frama_C_double_interval(0.0, 1.0);
        core.config.torque_rate = Frama_C_double_interval(0.0, 1e12);
        core.config.torque_band = Frama_C_double_interval(0.0, 1e12);
        core.config.torque_still = Frama_C_double_interval(0.0, 1e12);
        core.config.least_slip = Frama_C_double_interval(0.0, 1e12);
        core.config.observer = source % 4u;
        core.config.device = source % 2u;
        core.step = source;
        core.stages.step = source;
        core.stages.late_share = Frama_C_double_interval(0.0, 1.0);
        core.stages.rest = any();
        core.stages.side = any();
        core.stages.learned[0].gain = core.stages.learned[1].gain = Frama_C_double_interval(0.5, 2.0);
        core.estimate = any();
        core.field = any();
        core.theta.speed = any();
        core.alpha.speed = any();
        erc_torque_expect(&core, source % 1000u);
        (void)erc_torque_plausible(&core, any());
        within = core.meter.believed >= -LIMIT && core.meter.believed <= LIMIT;
        /*@ check believed: within == 1; */
        wrong = source;
        if (wrong >= 14u) {
            share = erc_held_share(5u, 21u, wrong);
            /*@ check zero: share == 0.0; */
        }
        asked = erc_at_most(any(), most);
        within = asked <= 1.0;
        /*@ check no_more: within == 1; */
    }
    return 0;
}
