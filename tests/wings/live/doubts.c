/* Every state of the doubt in a torque sensor and every reading that may come next, through the loop's own core: range, rate,
 * disagreement, repetition, infinity, a turned sign; held, then reduced, then zero, with an event that says why. What must
 * come of each is written here once more, and compared. Prints what it went through. */
#include "erc_config.h"
#include "erc_core.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PERIOD 1000000u
#define HOLD 5u
#define TRIP 21u
#define LIMIT 2.0
#define RATE 100.0 /* N m/s: a tenth of a newton metre in a period */
#define BAND 0.05
#define WELL 700u  /* periods after which it is known that the sensor has noise */
#define LATCHES 5u /* periods of disagreement that no later agreement takes back */
#define LAST 8u    /* readings that tell a turned sign */
#define SMALL 0.04 /* of the model's torque: turned, it is within the band */

enum reading { GOOD, BEYOND, JUMPS, OPPOSES, REPEATS, INFINITE, TURNED, READINGS };
enum order { NO_ORDER, ZERO, RESET, PROGRAM, ORDERS };

static unsigned long broken, steps, pairs;

static void must(int holds, const char *what, unsigned reading, unsigned doubt) {
    if (!holds && broken++ < 20u) {
        printf("broken: %s (reading %u, doubt %u)\n", what, reading, doubt);
    }
#ifdef ONE_IS_ENOUGH /* of a core that is known to break a promise, the rest of the way tells nothing more */
    if (broken > 0u) {
        printf("pairs %lu, steps %lu, broken %lu\n", pairs, steps, broken);
        exit(1);
    }
#endif
}

/* A model whose torque moves by more than a sensor may repeat, and follows from the field alone. */
static double size = 1.0;

static double level(uint64_t tick) {
    return size * (0.5 + 0.04 * sin(0.05 * (double)tick));
}

static uint64_t now;

static uint32_t effort_of(void *state, const double *in, double *effort) {
    (void)state;
    (void)in;
    *effort = level(now);
    return 0u;
}

static uint32_t steady_of(const double *in, double *effort) {
    *effort = 2.0 * (in[0] - in[1]);
    return 0u;
}

static uint32_t field_of(const double *in, double wanted, double *field) {
    (void)in;
    *field = 0.5 * wanted;
    return 0u;
}

static erc_config config_of(uint32_t observer) {
    erc_config c;
    memset(&c, 0, sizeof c);
    c.magic = ERC_CONFIG_MAGIC;
    c.version = ERC_CONFIG_VERSION;
    c.size = sizeof c;
    c.device = ERC_COAXIAL;
    c.period_ns = PERIOD;
    c.filter_g = 0.5;
    c.filter_h = 0.1;
    c.theta_glitch = c.alpha_glitch = 100.0;
    c.torque_limit = LIMIT;
    c.torque_rate = RATE;
    c.torque_band = BAND;
    c.torque_still = BAND;
    c.field_limit = 0.5;
    c.motor_limit = 0.95;
    c.rise_rate = c.fall_rate = 750.0;
    c.observer = observer;
    c.observer_bandwidth = 20.0;
    c.torque_lead = c.torque_lag = 2e-3;
    c.integral_rate = c.gain_rate = 1.0;
    c.torque_scale = 0.01;
    c.least_slip = 1.0;
    c.late_trip_ns = 20000000u;
    c.hold_samples = HOLD;
    c.trip_samples = TRIP;
    c.programs = 2;
    c.list[0] = (erc_program){ERC_TORQUE, ERC_SINE, 0, 0, 0.1, 7.0, 0.5, 0.1, 1.0, 0, 0};
    c.list[1] = (erc_program){ERC_FIELDS, ERC_SINE, 0, 0, 0.1, 7.0, 0.2, 0.1, 1.0, 0, 0};
    return c;
}

typedef struct {
    erc_core core;
    uint64_t seq;
    double last, field;
} rig;

static double read_as(const rig *r, enum reading kind) {
    const double noise = r->seq % 2u != 0u ? 1e-4 : -1e-4;
    switch (kind) {
    case BEYOND:
        return r->seq % 2u != 0u ? 1.5 * LIMIT : -1.5 * LIMIT;
    case JUMPS: /* to and fro, so that no jump becomes a believed level */
        return r->seq % 2u != 0u ? 0.9 * LIMIT : -0.9 * LIMIT;
    case OPPOSES:
        return r->core.meter.believed - 0.09 + noise;
    case REPEATS:
        return r->last;
    case INFINITE:
        return r->seq % 2u != 0u ? (double)INFINITY : -(double)INFINITY;
    case TURNED:
        return noise - level(now);
    default:
        return level(now) + noise;
    }
}

static erc_frame step(rig *r, enum reading kind, erc_command *out) {
    erc_frame frame;
    now++;
    r->seq++;
    r->last = read_as(r, kind);
    const erc_sample s = {r->seq, r->seq * PERIOD, 0.05 * (double)r->seq, 0.0, r->last, 0, 0};
    erc_core_step(&r->core, &s, 1u, now, 0, 0, out, &frame);
    r->field = out->field1 - out->field2;
    steps++;
    return frame;
}

/* A core that runs a program with a sensor that has been good, then wrong for some periods. */
static void arrive(rig *r, const erc_config *config, enum reading kind, uint32_t periods) {
    static const erc_model model = {effort_of, field_of, 0, 0, steady_of};
    erc_command out;
    memset(r, 0, sizeof *r);
    now = 0u;
    must(erc_config_error(config, 0) == 0, "a configuration that is allowed", kind, periods);
    erc_core_init(&r->core, config, 0, &model);
    for (uint32_t i = 0; i < WELL; i++) {
        const erc_frame frame = step(r, GOOD, &out);
        must((frame.events & ERC_TORQUE_DOUBTED) == 0u, "a good sensor is not doubted", kind, i);
    }
    must(r->core.state == ERC_RUNNING && r->field > 0.0, "it runs", kind, periods);
    for (uint32_t i = 0; i < periods; i++) {
        (void)step(r, kind, &out);
    }
}

static int asks_meter(const rig *r) {
    return (r->core.config.observer == ERC_BY_SENSOR && r->core.program == 0u) || r->core.config.meter_needed > 1.0;
}

/* Whether any doubt in the meter stops the program. */
static int stops(const rig *r) {
    return asks_meter(r) || r->core.config.meter_needed > 0.0;
}

/* Periods of the doubt that stops it: without a question for the meter only what the meter shows by itself. */
static uint32_t doubt_of(const rig *r) {
    return asks_meter(r) ? r->core.meter.doubted : (stops(r) ? r->core.meter.alone : 0u);
}

/* One reading, and all that must be true of what comes of it. */
static void one(rig *r, enum reading kind) {
    const uint32_t doubted = r->core.meter.doubted, alone = r->core.meter.alone, before = doubt_of(r), state = r->core.state;
    const uint32_t latched = (r->core.meter.reason & ERC_DISAGREES) != 0u && doubted > LATCHES;
    const double earlier = r->field, believed = r->core.meter.believed;
    const double reached = 1e-3 * RATE * (double)(r->core.meter.since + 1u); /* since it was believed for the last time */
    const erc_share learned = r->core.stages.learned[0];
    erc_command out;
    const erc_frame frame = step(r, kind, &out);
    const uint32_t now_doubted = r->core.meter.doubted, doubt = doubt_of(r), wrong = r->core.meter.wrong;
    const uint32_t by_itself = wrong && (r->core.meter.reason & ERC_DISAGREES) == 0u;
    /* Several readings have told a turned sign at once. */
    const uint32_t turned = wrong && !by_itself && doubted < LATCHES && now_doubted == LATCHES + 1u;
    must(fabs(r->core.meter.believed) <= LIMIT, "only what can be is believed", kind, before);
    must(kind != BEYOND || (frame.events & ERC_OUT_OF_RANGE) != 0u, "beyond its range", kind, before);
    must(kind != INFINITE || wrong, "infinite", kind, before);
    must(fabs(r->last - believed) <= reached || wrong, "a jump", kind, before);
    must(kind == GOOD || !wrong || (frame.events & ERC_TORQUE_DOUBTED) != 0u, "an event names the sensor", kind, before);
    must(!wrong || (frame.events & (ERC_OUT_OF_RANGE | ERC_GLITCH | ERC_STUCK | ERC_DISAGREES)) != 0u, "and the reason", kind,
         before);
    must(!wrong || now_doubted == doubted + 1u || turned, "doubt grows by one", kind, doubted);
    must(wrong || now_doubted == (latched ? doubted + 1u : doubted) || (!latched && now_doubted + 1u == doubted),
         "or falls by one", kind, doubted);
    must(r->core.meter.alone == (by_itself ? alone + 1u : (alone > 0u ? alone - 1u : 0u)), "what it shows by itself", kind,
         alone);
    must(!wrong || memcmp(&learned, &r->core.stages.learned[0], sizeof learned) == 0, "nothing is learned", kind, before);
    if (!stops(r)) {
        must(state != ERC_RUNNING || r->core.state == ERC_RUNNING, "who asks no meter goes on", kind, before);
        return;
    }
    if (state == ERC_RUNNING) {
        must((r->core.state == ERC_TRIPPED) == (doubt >= TRIP), "it trips in time, and not before", kind, doubt);
        must(doubt == 0u || doubt >= TRIP || (frame.events & (doubt <= HOLD ? ERC_HOLD : ERC_DEGRADE)) != 0u, "held or reduced",
             kind, doubt);
        must(doubt <= before || fabs(r->field) <= fabs(earlier) + 1e-12, "no field grows as doubt grows", kind, doubt);
        must(doubt + ERC_ZERO_BEFORE_TRIP < TRIP || r->field == 0.0, "zero before the trip", kind, doubt);
    }
    if (r->core.state != ERC_RUNNING) {
        must(r->field == 0.0 && out.motor_torque == 0.0, "zero unless it runs", kind, doubt);
        must(state != ERC_RUNNING || (r->core.trip_reason & ERC_TORQUE_DOUBTED) != 0u, "the trip names the sensor", kind, doubt);
    }
}

static void give(rig *r, enum order kind) {
    static const uint32_t kinds[ORDERS] = {0, ERC_ORDER_ZERO, ERC_ORDER_RESET, ERC_ORDER_PROGRAM};
    const erc_order order = {ERC_ORDER_MAGIC, kinds[kind], 0.0, 0, 0};
    const uint32_t state = r->core.state, doubted = doubt_of(r) > 0u && r->core.meter.wrong;
    if (kind == NO_ORDER) {
        return;
    }
    (void)erc_core_order(&r->core, &order);
    must(kind != RESET || state != ERC_TRIPPED || (r->core.state == ERC_READY) == !doubted, "no reset while it is wrong", kind,
         r->core.meter.doubted);
    must(kind != PROGRAM || state != ERC_TRIPPED || r->core.state == ERC_TRIPPED, "no program out of a trip", kind, 0);
}

/* A pause without samples in a doubt: the doubt goes on meanwhile, and a wrong reading after it counts the pause too. */
static void pause_in_doubt(const rig *there, enum reading kind, uint32_t pause) {
    rig r = *there;
    const uint32_t before = doubt_of(&r), wrong = r.core.meter.wrong, running = r.core.state == ERC_RUNNING;
    double field = r.field;
    erc_command out;
    erc_frame frame;
    for (uint32_t i = 1u; i <= pause; i++) {
        now++;
        r.seq++; /* the rig goes on: its samples are lost */
        erc_core_step(&r.core, 0, 0u, now, 0, 0, &out, &frame);
        r.field = out.field1 - out.field2;
        must(fabs(r.field) <= fabs(field) + 1e-12, "no field grows in a pause", kind, before);
        must(!stops(&r) || before + i + ERC_ZERO_BEFORE_TRIP < TRIP || r.field == 0.0, "zero as without a pause", kind,
             before + i);
        field = r.field;
    }
    frame = step(&r, kind, &out);
    const uint32_t grew = doubt_of(&r) > 0u && (asks_meter(&r) || (r.core.meter.reason & ERC_DISAGREES) == 0u);
    if (before > 0u && wrong && r.core.meter.wrong && grew) {
        must(doubt_of(&r) >= before + pause + 1u, "a pause in doubt counts", kind, before);
        must(!running || (r.core.state == ERC_TRIPPED) == (doubt_of(&r) >= TRIP || pause >= TRIP), "it trips as without a pause",
             kind, doubt_of(&r));
    }
    (void)frame;
    pairs++;
}

/* Each doubt by one kind of reading, and all that may come next. */
static void from(const erc_config *config, enum reading was) {
    for (uint32_t periods = 0; periods <= TRIP + 2u; periods++) {
        rig there;
        arrive(&there, config, was, periods);
        must(was != TURNED || periods < LAST || there.core.meter.doubted > LATCHES, "its last readings tell a turned sign", was,
             periods);
        const uint64_t then = now;
        for (uint32_t pause = 1; pause <= TRIP; pause++) {
            now = then;
            pause_in_doubt(&there, was, pause);
        }
        for (unsigned e = 0; e < READINGS * ORDERS * READINGS; e++) {
            rig r = there;
            now = then;
            give(&r, (enum order)(e / READINGS % ORDERS));
            one(&r, (enum reading)(e % READINGS));
            for (uint32_t i = 0; i < TRIP + 2u; i++) {
                one(&r, (enum reading)(e / READINGS / ORDERS));
            }
            pairs++;
        }
    }
}

int main(void) {
    for (uint32_t observer = ERC_BY_SENSOR - 1u; observer <= ERC_BY_SENSOR; observer++) {
        for (uint32_t program = 0; program < 2u; program++) {
            for (uint32_t needed = 0; needed <= 2u; needed++) {
                erc_config config = config_of(observer);
                config.program = program;
                config.meter_needed = (double)needed;
                for (unsigned was = BEYOND; was < READINGS; was++) {
                    from(&config, (enum reading)was);
                }
                size = SMALL;
                from(&config, TURNED);
                size = 1.0;
            }
        }
    }
    printf("pairs %lu, steps %lu, broken %lu\n", pairs, steps, broken);
    return broken != 0u;
}
