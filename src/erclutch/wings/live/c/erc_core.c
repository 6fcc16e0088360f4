#include "erc_core.h"

#include "erc_control.h"
#include "erc_interlock.h"
#include "erc_plausible.h"
#include "erc_sensors.h"
#include "erc_turned.h"

#include <math.h>
#include <string.h>

#define OUTSIDE 1u /* the model's flag */

uint32_t erc_core_size(void) {
    return (uint32_t)sizeof(erc_core);
}

uint32_t erc_core_config_size(void) {
    return (uint32_t)sizeof(erc_config);
}

uint32_t erc_core_state(const erc_core *core) {
    return core->state;
}

void erc_core_init(erc_core *core, const erc_config *config, const erc_row *table, const erc_model *model) {
    memset(core, 0, sizeof *core);
    core->config = *config;
    core->table = table;
    if (model != 0) {
        core->model = *model;
    }
    core->dt = 1e-9 * (double)config->period_ns;
    core->momentum.g = config->filter_g;
    core->momentum.h = config->filter_h;
    core->theta.wrap = config->theta_wrap;
    core->theta.glitch = config->theta_glitch;
    core->alpha.wrap = config->alpha_wrap;
    core->alpha.glitch = config->alpha_glitch;
    core->theta.fastest = config->theta_fastest;
    core->alpha.fastest = config->alpha_fastest;
    core->alpha.farthest = config->alpha_limit;
    core->alpha.end = config->stroke;
    core->torque = (double)NAN;
    core->meter.reading = (double)NAN;
    core->estimate = (double)NAN;
    core->reference = (double)NAN;
    core->motor = (double)NAN;
    core->resync = 1u;
    core->state = ERC_STARTING;
    core->program = config->program;
}

static void trip(erc_core *core, uint32_t events) {
    if (core->state == ERC_TRIPPED) {
        return;
    }
    core->state = ERC_TRIPPED;
    core->trip_reason = events;
}

/* Periods in which a sensor has been wrong that the program's control depends on, or that is needed in any case. */
static uint32_t doubted(const erc_core *core) {
    const uint32_t mode = core->config.list[core->program].mode;
    const bool computed = mode == ERC_TRACK && core->config.track_bandwidth > 0.0;
    const bool torque = mode == ERC_TORQUE || mode == ERC_IMPEDANCE || mode == ERC_WALL || computed;
    const bool asked = torque && core->config.observer == ERC_BY_SENSOR;
    /* A sensor that never read two torques may be none. */
    const uint32_t alone = core->config.meter_needed > 0.0 && core->meter.count > 0.0 ? core->meter.alone : 0u;
    const uint32_t meter = asked || core->config.meter_needed > 1.0 ? core->meter.doubted : alone;
    /* Of meter and encoder one is wrong, and which one nothing says. */
    const bool by_fields = mode == ERC_FIELDS || mode == ERC_REST;
    const uint32_t either = by_fields ? 0u : erc_momentum_periods(core, core->config.hold_samples);
    return meter > either ? meter : either;
}

/* Clears the trip, and starts nothing: the fields stay at zero until a program is run. The model forgets all samples. */
static int reset(erc_core *core) {
    if (core->state != ERC_TRIPPED || core->missing > 0u || (doubted(core) > 0u && core->meter.wrong)) {
        return 0; /* nothing to reset, or still no sensors that can be believed */
    }
    core->state = ERC_READY;
    core->trip_reason = 0u;
    core->rig_seen = 0u;
    core->meter.doubted = core->meter.alone = core->momentum.doubted = 0u;
    core->momentum.begun = false;
    if (core->model.reset != 0) {
        core->model.reset(core->model.state);
    }
    return 1;
}

/* Runs a program from its beginning: never out of a trip, and never without sensors. */
static int run(erc_core *core, double program) {
    if (!(program >= 0.0 && program < (double)core->config.programs) || core->state == ERC_TRIPPED ||
        (core->state == ERC_READY && core->missing > 0u)) {
        return 0;
    }
    if (core->state == ERC_READY) {
        core->state = ERC_RUNNING;
    }
    core->momentum.doubted = 0u; /* asked anew */
    erc_control_start(core, (uint32_t)program, core->step);
    return 1;
}

int erc_core_order(erc_core *core, const erc_order *order) {
    const double value = order->value;
    int done = 0;
    switch (order->kind) {
    case ERC_ORDER_STOP:
        core->pending |= ERC_ORDER;
        return 1;
    case ERC_ORDER_ZERO:
        trip(core, ERC_ORDER);
        done = 1;
        break;
    case ERC_ORDER_RESET:
        done = reset(core);
        break;
    case ERC_ORDER_PROGRAM:
        done = run(core, value);
        break;
    case ERC_ORDER_MOTOR:
        if (fabs(value) <= core->config.motor_limit) {
            core->motor = value;
            done = 1;
        }
        break;
    default:
        break;
    }
    core->pending |= done ? ERC_ORDER : ERC_ORDER_REFUSED;
    return 0;
}

void erc_core_stop(erc_core *core) {
    core->stopping = 1u;
}

/* A sensor that has been stuck for some periods has misled control: what was asked before them is held, if it is less. */
static void forget_latest(erc_core *core, uint64_t tick) {
    const double *before = core->earlier[(tick - ERC_STILL - 1u) % ERC_EARLIER];
    core->asked1 = erc_at_most(core->asked1, before[0]);
    core->asked2 = erc_at_most(core->asked2, before[1]);
}

/* What to ask of the interlock: control's wish, or what is left of the last one. While a sensor is in doubt no field
 * grows. */
static uint32_t wish(erc_core *core, uint64_t tick, double ask[3]) {
    const uint32_t doubt = doubted(core);
    /* A doubt goes on while no sample comes. */
    const uint32_t wrong = core->missing < UINT32_MAX - doubt ? core->missing + doubt : UINT32_MAX;
    /* Zero so long before the trip that the field is zero 20 ms after a failure even if much of that time went elsewhere. */
    const double share = erc_held_share(core->config.hold_samples, core->config.trip_samples, wrong);
    uint32_t events = 0u;
    if (core->momentum.doubted == 1u || (core->momentum.doubted > 1u && core->momentum.before == 0u)) {
        forget_latest(core, tick);
    }
    if (core->missing == 0u) {
        events = erc_control(core, tick, ask);
        core->asked_motor = ask[2];
    } else {
        if (core->missing == 1u && (core->lost_by & ERC_STUCK) != 0u) {
            forget_latest(core, tick);
        }
        ask[0] = core->asked1;
        ask[1] = core->asked2;
        ask[2] = core->asked_motor;
    }
    if (wrong == 0u) {
        core->asked1 = ask[0];
        core->asked2 = ask[1];
        core->earlier[tick % ERC_EARLIER][0] = ask[0];
        core->earlier[tick % ERC_EARLIER][1] = ask[1];
        return events;
    }
    core->asked1 = erc_at_most(ask[0], core->asked1); /* what has fallen in doubt does not come back in it */
    core->asked2 = erc_at_most(ask[1], core->asked2);
    ask[0] = share * core->asked1;
    ask[1] = share * core->asked2;
    return events | (share < 1.0 ? ERC_DEGRADE : ERC_HOLD);
}

static uint32_t trip_checks(erc_core *core, uint64_t late_ns, uint32_t events) {
    if (core->state == ERC_STARTING && core->missing == 0u) {
        core->state = ERC_RUNNING;
        erc_control_start(core, core->program, core->step);
    }
    const int armed = core->state == ERC_RUNNING || core->state == ERC_READY;
    if (!armed) {
        /* tripped or without a sample: nothing more can trip */
    } else if (core->missing >= core->config.trip_samples) {
        trip(core, core->lost_by);
    } else if (doubted(core) >= core->config.trip_samples) {
        const bool either = erc_momentum_periods(core, core->config.hold_samples) >= core->config.trip_samples;
        trip(core, either ? erc_momentum_doubts(core) : core->meter.reason);
    } else if (late_ns > core->config.late_trip_ns) {
        trip(core, ERC_OVERRUN);
    } else if ((events & ERC_RIG_WATCHDOG) != 0u) {
        trip(core, ERC_RIG_WATCHDOG);
    } else if ((events & ERC_RIG_FAULT) != 0u) {
        trip(core, ERC_RIG_FAULT);
    }
    if (core->state == ERC_TRIPPED && core->missing >= core->config.trip_samples) {
        core->resync = 1u; /* the rig may be started anew meanwhile, an encoder may have slipped: begin again there */
    }
    return armed && core->state == ERC_TRIPPED ? ERC_TRIP : 0u;
}

static uint32_t estimate(erc_core *core, const double applied[3]) {
    /* For alarms and adaptation: of a torque that can be, where the slip says what it has to be. */
    const bool known = core->missing == 0u && core->meter.good && erc_slipping(core);
    const double measured = known ? core->torque : (double)NAN;
    const double coaxial[5] = {applied[0], applied[1], core->theta.speed, core->alpha.speed, measured};
    const double single[3] = {applied[0], core->theta.speed - core->alpha.speed, measured};
    double effort = (double)NAN;
    if (core->model.step == 0 || core->state == ERC_STARTING) {
        return 0u;
    }
    const uint32_t flags =
        core->model.step(core->model.state, core->config.device == ERC_SINGLE ? single : coaxial, &effort);
    core->estimate = effort;
    erc_torque_guess(core, (flags & OUTSIDE) != 0u);
    return flags;
}

void erc_core_step(erc_core *core, const erc_sample *samples, uint32_t count, uint64_t tick, uint64_t late_ns,
                   uint32_t events, erc_command *command, erc_frame *frame) {
    double ask[3] = {0.0, 0.0, 0.0}, out[3] = {0.0, 0.0, 0.0};
    const uint64_t periods = tick > core->step ? tick - core->step : 1u;
    core->step = tick;
    events |= core->pending;
    core->pending = 0u;
    events |= erc_sensors_take(core, samples, count, periods);
    if (periods > 1u) {
        events |= ERC_OVERRUN;
    }
    events |= trip_checks(core, late_ns, events);
    if (core->stopping != 0u) {
        events |= ERC_STOPPING;
    }
    if (core->state == ERC_RUNNING && core->stopping == 0u) {
        events |= wish(core, tick, ask);
        events |= erc_interlock(&core->config, core->field, core->alpha.measured, core->theta.speed, ask, out);
    } else {
        core->reference = (double)NAN;
    }
    core->field = out[0] - out[1];
    core->driven = out[2];
    const int single = core->config.device == ERC_SINGLE;
    if (single) { /* its one field has a sign where a recording had it */
        out[0] = core->field;
        out[1] = 0.0;
    }
    frame->flags = estimate(core, out);

    command->field1 = out[0];
    command->field2 = out[1];
    command->motor_torque = out[2];
    command->flags = core->stopping;
    command->device = core->config.device;

    frame->theta = core->theta.measured - (single ? core->alpha.measured : 0.0);
    frame->alpha = core->alpha.measured;
    frame->theta_dot = core->theta.speed - (single ? core->alpha.speed : 0.0);
    frame->alpha_dot = core->alpha.speed;
    frame->field1 = out[0];
    frame->field2 = out[1];
    frame->motor_torque = out[2];
    frame->torque = core->missing == 0u ? core->torque : (double)NAN;
    frame->estimate = core->estimate;
    frame->reference = core->reference;
    frame->events = events;
}
