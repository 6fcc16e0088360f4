/* The size of a number: one instruction where the compiler knows it. */
static double size(double x) {
#if defined(__GNUC__) && !defined(__FRAMAC__)
    return @SIZE@(x);
#else
    return x < 0.0 ? -x : x;
#endif
}

/* The model's torque at rest under a signed field. */
static double erc_at_rest(const erc_core *core, const double *in, double field) {
    double held[@HELD@];
    (void)core;
    (void)NAME_slips(in, held);
    return @REST@(field, held, 0.0);
}

@TURNED@
@PLAUSIBLE@
@TORQUE@
@INTERLOCK@
/* NaN is within nothing. */
static bool within(const double *settings, uint32_t count, double least) {
    bool good = true;
    uint32_t i;
    for (i = 0u; i < count; i++) {
        good = good && settings[i] >= least && settings[i] <= @MOST@;
    }
    return good;
}

static bool usable(const erc_config *config) {
    const double above_zero[] = {@ABOVE_ZERO@};
    const double from_zero[] = {@FROM_ZERO@};
    const double with_sign[] = {@SIGNED@};
    return config->observer <= ERC_BY_MOTION && config->period_ns >= 100000u && config->period_ns <= 1000000000u &&
           within(above_zero, (uint32_t)(sizeof above_zero / sizeof above_zero[0]), @LEAST@) &&
           within(from_zero, (uint32_t)(sizeof from_zero / sizeof from_zero[0]), 0.0) &&
           within(with_sign, (uint32_t)(sizeof with_sign / sizeof with_sign[0]), -@MOST@);
}

/* Whether a speed is further from the last one than it can have come since; most is for one period, 0: not asked. */
static bool jumped(double speed, double last, double most, uint32_t periods) {
    return fabs(speed - last) > most * (double)periods && most > 0.0; /* in health the first is not so */
}

/* Which speed cannot be, beside the last good sample; 0 if both can. */
static uint32_t speed_events(const erc_core *core, const erc_input *input, double slip) {
    const double earlier = ERC_DEVICE == ERC_SINGLE ? core->theta.speed - core->alpha.speed : core->theta.speed;
    uint32_t events = 0u;
    if (core->since == 0u) {
        return 0u; /* no sample yet */
    }
    if (jumped(slip, earlier, core->config.theta_glitch, core->since)) {
        events = ERC_THETA_DOUBTED | ERC_GLITCH;
    }
    if (ERC_DEVICE != ERC_SINGLE && jumped(input->alpha_dot, core->alpha.speed, core->config.alpha_glitch, core->since)) {
        events |= ERC_ALPHA_DOUBTED | ERC_GLITCH;
    }
    return events;
}

uint32_t erc_control_reset(erc_core *core, const erc_config *config) {
    static const erc_core none;
    const bool good = NAME_exact() != 0u && usable(config);
    const double zero = 0.0;
    *core = none;
    if (good) {
        core->config = *config;
    }
    core->dt = 1e-9 * (double)(uint32_t)core->config.period_ns;
    core->estimate = core->meter.reading = zero / zero; /* nothing is known yet */
    core->momentum.g = @FILTER_G@; /* speeds through such a filter are as late */
    core->momentum.h = @FILTER_H@;
    core->step = 1u; /* the first sample counts as the first after a gap */
    (void)NAME_reset(&core->model);
    erc_torque_start(core);
    return good ? 1u : 0u;
}

uint32_t erc_control_step(erc_core *core, const erc_input *input, erc_output *output) {
    double ask[3] = {0.0, 0.0, 0.0}, applied[3] = {0.0, 0.0, 0.0}, sample[5] = {0.0, 0.0, 0.0, 0.0, 0.0};
    uint32_t events = 0u, doubt, either, flags;
    const bool placed = isfinite(input->alpha) || !(core->config.stroke > 0.0);
    /* NaN is no speed either. Both sides of a single device may turn fast: its slip is looked at. */
    const double slip = ERC_DEVICE == ERC_SINGLE ? input->theta_dot - input->alpha_dot : input->theta_dot;
    const bool usual = fabs(slip) <= @FASTEST@ && fabs(input->alpha_dot) <= (ERC_DEVICE == ERC_SINGLE ? 1e6 : @FASTEST@);
    const bool finite = isfinite(input->wanted) && isfinite(input->rate) && usual && isfinite(input->motor_torque) && placed;
    double theta_dot = input->theta_dot, alpha_dot = input->alpha_dot; /* for the model */
    bool asked, good;
    if (finite) {
        events = speed_events(core, input, slip);
    }
    if (events != 0u) {
        theta_dot = core->theta.speed;
        alpha_dot = core->alpha.speed;
    }
    good = finite && events == 0u;
    /* Speeds that cannot be, one after another, are of a sensor that is wrong: the speed at which it then rests tells
     * nothing. A sample that is none is no speed. */
    if (good) {
        core->astray = 0u;
    } else if (core->astray <= @HOLD@ && (events != 0u || (core->since > 0u && isfinite(slip) && !usual))) {
        core->astray++;
    } else {
        /* no more is asked */
    }
    core->tripped = core->tripped || core->astray > @HOLD@;
    if (good) {
        core->since = 1u;
    } else if (core->since > 0u && core->since < MOST_PERIODS) {
        core->since++;
    } else {
        /* no sample yet, or none for so long that any speed can be */
    }
    core->step += good ? 1u : 2u; /* after a gap the field comes back slowly */
    erc_torque_expect(core, 1u);
    if (good) {
        core->theta.speed = input->theta_dot;
        core->alpha.speed = input->alpha_dot;
        core->torque = input->torque;
        core->alpha.measured = core->config.stroke > 0.0 ? input->alpha : 0.0;
        core->driven = core->asked_motor; /* until now */
        core->asked_motor = input->motor_torque;
        events |= erc_torque_plausible(core, input->torque);
    }
    if (good) {
        events |= erc_momentum_plausible(core);
    }
    else {
        core->momentum.begun = false;
    }
    doubt = core->config.observer == ERC_BY_SENSOR ? core->meter.doubted : 0u;
    either = erc_momentum_periods(core, @HOLD@);
    doubt = doubt > either ? doubt : either;
    core->tripped = core->tripped || doubt >= @TRIP@;
    events |= core->tripped ? ERC_TRIP : 0u;
    asked = good && core->config.field_limit > 0.0 && !core->tripped;
    if (asked) {
        const double field = erc_torque_field(core, input->wanted, input->rate, &events);
        ask[0] = field > 0.0 ? field : 0.0;
        ask[1] = field < 0.0 && ERC_DEVICE != ERC_SINGLE ? -field : 0.0;
    }
    if (doubt == 0u) {
        core->asked[0] = ask[0];
        core->asked[1] = ask[1];
    } else {
        const double share = erc_held_share(@HOLD@, @TRIP@, doubt);
        events |= share < 1.0 ? ERC_DEGRADE : ERC_HOLD;
        core->asked[0] = erc_at_most(ask[0], core->asked[0]);
        core->asked[1] = erc_at_most(ask[1], core->asked[1]);
        ask[0] = share * core->asked[0];
        ask[1] = share * core->asked[1];
    }
    events |= erc_interlock(&core->config, core->field, input->alpha, core->theta.speed, ask, applied);
    core->field = applied[0] - applied[1];
    @MEASURED@
    @SAMPLE@
    @KNOWN@
    flags = @STEP@;
    erc_torque_guess(core, (flags & NAME_OUTSIDE_RANGE) != 0u);
    output->field1 = applied[0];
    output->field2 = applied[1];
    output->estimate = core->estimate;
    return events | flags | (finite ? 0u : NAME_NON_FINITE);
}
