/* For Frama-C's Eva: the plausibility of a torque sensor, and of it beside the output's motion, in a loop of unknown length,
 * fed with any bits, as the core calls it; what is left of a command by it; and what a sensor may add to a torque. */
#include "erc_torque.c" /* for with_sensor() */

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
        uint32_t wrong, said;
        double asked, share, most = Frama_C_double_interval(0.0, 1.0);
        core.config.torque_rate = Frama_C_double_interval(0.0, 1e12);
        core.config.torque_band = Frama_C_double_interval(0.0, 1e12);
        core.config.torque_still = Frama_C_double_interval(0.0, 1e12);
        core.config.least_slip = Frama_C_double_interval(0.0, 1e12);
        core.config.load_inertia = Frama_C_double_interval(0.0, 1e12);
        core.config.load_friction = Frama_C_double_interval(0.0, 1e12);
        core.config.load_drag = Frama_C_double_interval(0.0, 1e12);
        core.config.load_band = Frama_C_double_interval(0.0, 1e12);
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
        erc_torque_guess(&core, source % 2u);
        (void)erc_torque_plausible(&core, any());
        within = core.meter.believed >= -LIMIT && core.meter.believed <= LIMIT;
        /*@ check believed: within == 1; */
        core.torque = any();
        core.driven = Frama_C_double_interval(-1e9, 1e9); /* the interlock's */
        core.config.stroke = Frama_C_double_interval(0.0, 1e12);
        core.alpha.measured = any();
        if (core.momentum.doubted > 1u) { /* no later agreement takes that back */
            said = erc_momentum_plausible(&core);
            /*@ check latched: said != 0 && core.momentum.doubted > 1; */
        } else {
            (void)erc_momentum_plausible(&core);
        }
        wrong = source;
        if (wrong >= 14u) {
            share = erc_held_share(5u, 21u, wrong);
            /*@ check zero: share == 0.0; */
        }
        core.config.observer = ERC_BY_SENSOR;
        core.config.torque_scale = Frama_C_double_interval(1e-9, 1.0);
        core.stages.usual = Frama_C_double_interval(-1.0, 1.0);
        core.stages.slow = Frama_C_double_interval(0.0, 1.0);
        core.stages.products = core.stages.squares = 0.0; /* no rule yet: at most a tenth */
        asked = with_sensor(&core, Frama_C_double_interval(-1.0, 1.0), any());
        within = asked >= -2.31 && asked <= 2.31; /* a tenth beyond 1 and what it adds as a rule, 1, and of the scale, 1 */
        /*@ check tenth: within == 1; */
        asked = erc_at_most(any(), most);
        within = asked <= 1.0;
        /*@ check no_more: within == 1; */
    }
    return 0;
}
