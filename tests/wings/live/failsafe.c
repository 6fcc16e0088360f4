/* Every pair of a state of the failsafe and an event, then random sequences, through the loop's own core. What must come
 * of each pair is written here once more, as a machine of four states, and compared. Prints what it went through. */
#include "erc_config.h"
#include "erc_core.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PERIOD 1000000u
#define LATE_TRIP 20000000u

enum sample { NONE, GOOD, NOT_FINITE, JUMP, DOUBLE, FAR_AHEAD, FAULT, WATCHDOG, OLD_AND_NEW, SAMPLES };
enum order { NO_ORDER, STOP, ZERO, RESET, PROGRAM, NO_PROGRAM, MOTOR, MOTOR_TOO_MUCH, UNKNOWN, ORDERS };
enum lateness { ON_TIME, LATE, TOO_LATE, LATENESSES };
enum slept { ONE, THREE, TOO_LONG, SLEPTS };
enum ending { GOES_ON, ENDS, ENDINGS };

static unsigned long long seed = 88172645463325252ULL;
static unsigned long long next(void) {
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return seed;
}

/* Any number, infinities and NaN among them, and often a sensible one. */
static double any(void) {
    const unsigned long long bits = next();
    double x;
    memcpy(&x, &bits, sizeof x);
    return (next() & 3u) != 0u ? (double)(next() % 2001u) / 1000.0 - 1.0 : x;
}

static uint32_t any_effort(void *state, const double *in, double *effort) {
    (void)state;
    (void)in;
    *effort = any();
    return (uint32_t)next();
}

static uint32_t any_steady(const double *in, double *effort) {
    return any_effort(0, in, effort);
}

static uint32_t any_field(const double *in, double wanted, double *field) {
    (void)in;
    (void)wanted;
    *field = any();
    return (uint32_t)next();
}

static unsigned long broken, steps, pairs, changes[5][5];

static void must(int holds, const char *what) {
    if (!holds && broken++ < 10u) {
        printf("broken: %s\n", what);
    }
#ifdef ONE_IS_ENOUGH /* of a core that is known to break a promise, the rest of the way tells nothing more */
    if (broken > 0u) {
        printf("pairs %lu, steps %lu, broken %lu\n", pairs, steps, broken);
        exit(1);
    }
#endif
}

static erc_row table[64];

static erc_config config_of(uint32_t device, uint32_t hold, uint32_t trip, double rates, uint32_t observer) {
    erc_config c;
    memset(&c, 0, sizeof c);
    c.magic = ERC_CONFIG_MAGIC;
    c.version = ERC_CONFIG_VERSION;
    c.size = sizeof c;
    c.device = device;
    c.period_ns = PERIOD;
    c.filter_g = 0.5;
    c.filter_h = 0.1;
    c.theta_glitch = c.alpha_glitch = 100.0;
    c.field_limit = 0.5;
    c.motor_limit = 0.95;
    c.rise_rate = c.fall_rate = rates;
    c.stroke = 3.0;
    c.k_p = 10.0;
    c.k_d = 0.1;
    c.torque_p = c.torque_i = 1.0;
    c.observer = observer;
    c.observer_bandwidth = 20.0;
    c.torque_lead = c.torque_lag = 2e-3;
    c.integral_rate = c.gain_rate = 10.0;
    c.torque_scale = 0.01;
    c.least_slip = 1.0;
    c.drive_inertia = c.output_inertia = 2e-4;
    c.track_bandwidth = observer % 2u == 0u ? 0.0 : 5.0;
    c.track_integral = 1.0;
    c.stiffness = 0.5;
    c.damping = c.wall_play = 0.01;
    c.late_trip_ns = LATE_TRIP;
    c.hold_samples = hold;
    c.trip_samples = trip;
    c.programs = 6;
    for (uint32_t i = 0; i < 4u; i++) {
        c.list[i] = (erc_program){i, ERC_SINE, 0, 0, 3.0, 7.0, 0.1, 0.3, 1.0, 0, 0};
    }
    c.list[4] = (erc_program){ERC_FIELDS, ERC_TABLE, ERC_REPEAT, 0, 0.0, 0.0, 0.0, 0.0, 1.0, 0, 64};
    c.list[5] = c.list[1];
    c.list[5].mode = device == ERC_SINGLE ? ERC_WALL : ERC_IMPEDANCE;
    c.list[5].flags = ERC_RELATIVE;
    return c;
}

/* A core, what the rig has sent it so far, and what the machine of four states expects. */
typedef struct {
    erc_core core;
    uint64_t seq, tick;
    uint32_t state, ending;
    double field;
} rig;

static void start(rig *r, const erc_config *config) {
    static const erc_model model = {any_effort, any_field, 0, 0, any_steady};
    memset(r, 0, sizeof *r);
    must(erc_config_error(config, 64) == 0, "a configuration that is allowed");
    erc_core_init(&r->core, config, table, &model);
    r->state = ERC_STARTING;
}

static erc_sample sample_of(rig *r, enum sample kind) {
    r->seq += kind == DOUBLE ? 0u : (kind == FAR_AHEAD ? 5000u : 1u);
    erc_sample s = {r->seq, r->seq * PERIOD, 1e-3 * (double)r->seq, 0.0, 0.1, 0, 0};
    s.theta = kind == NOT_FINITE ? (double)NAN : s.theta + (kind == JUMP ? 50.0 : 0.0);
    s.status = kind == FAULT ? ERC_STATUS_FAULT : (kind == WATCHDOG ? ERC_STATUS_WATCHDOG : 0u);
    if (kind == FAR_AHEAD && r->core.resync == 0u) {
        r->seq -= 5000u; /* else the core begins there */
    }
    return s;
}

static erc_order order_of(enum order kind) {
    erc_order o = {ERC_ORDER_MAGIC, 0, 0.0, 0, 0};
    const uint32_t kinds[ORDERS] = {0,
                                    ERC_ORDER_STOP,
                                    ERC_ORDER_ZERO,
                                    ERC_ORDER_RESET,
                                    ERC_ORDER_PROGRAM,
                                    ERC_ORDER_PROGRAM,
                                    ERC_ORDER_MOTOR,
                                    ERC_ORDER_MOTOR,
                                    99};
    o.kind = kinds[kind];
    o.value = kind == NO_PROGRAM ? 7.0 : (kind == MOTOR_TOO_MUCH ? 2.0 : (kind == MOTOR ? 0.5 : (double)(next() % 6u)));
    return o;
}

/* Orders come between steps; what must be true right after each. */
static void give(rig *r, enum order kind) {
    const erc_order order = order_of(kind);
    const int sensors = r->core.missing == 0u;
    const int end = erc_core_order(&r->core, &order);
    if (kind == ZERO) {
        r->state = ERC_TRIPPED;
    } else if (kind == RESET && r->state == ERC_TRIPPED && sensors) {
        r->state = ERC_READY;
    } else if (kind == PROGRAM && r->state == ERC_READY && sensors) {
        r->state = ERC_RUNNING;
    }
    must(r->core.state == r->state, "state after an order");
    must(end == (kind == STOP), "only the order to stop ends the loop");
}

/* What a step may put out: one field at most, within limits, and zero unless the machine runs. */
static void check_output(const rig *r, const erc_command *out, const erc_frame *frame) {
    const erc_config *c = &r->core.config;
    const double field = out->field1 - out->field2;
    must(isfinite(out->field1) && isfinite(out->field2) && isfinite(out->motor_torque), "finite");
    if (c->device == ERC_SINGLE) { /* one field, with a sign where a table has a second column */
        must(out->field2 == 0.0, "a single device has no second field");
    } else {
        must(out->field1 >= 0.0 && out->field2 >= 0.0 && !(out->field1 > 0.0 && out->field2 > 0.0), "never both fields");
    }
    must(fabs(out->field1) <= c->field_limit && out->field2 <= c->field_limit, "fields within their limit");
    must(fabs(out->motor_torque) <= c->motor_limit, "motor torque within its limit");
    must(frame->field1 == out->field1 && frame->field2 == out->field2, "the frame says what went out");
    must(out->flags == r->ending, "the last command says so");
    if (r->state != ERC_RUNNING || r->ending != 0u) {
        must(field == 0.0 && out->motor_torque == 0.0, "zero in the very step unless it runs");
        return;
    }
    must(fabs(field) - fabs(r->field) <= 1e-3 * c->rise_rate + 1e-12, "not faster than the supply");
    must(r->core.missing < c->trip_samples, "running without samples for too long");
    if (r->core.missing + ERC_ZERO_BEFORE_TRIP >= c->trip_samples && 1e-3 * c->fall_rate > c->field_limit) {
        must(field == 0.0, "zero some periods before the trip");
    }
}

static void step(rig *r, enum sample kind, uint64_t late, uint64_t periods, uint32_t events) {
    const uint32_t before = r->state, missing = r->core.missing, resync = r->core.resync;
    erc_sample samples[2];
    uint32_t count = kind == NONE ? 0u : 1u;
    if (kind == OLD_AND_NEW) {
        samples[0] = sample_of(r, DOUBLE);
        samples[1] = sample_of(r, GOOD);
        count = 2u;
    } else if (kind != NONE) {
        samples[0] = sample_of(r, kind);
    }
    erc_command out;
    erc_frame frame;
    r->tick += periods;
    erc_core_step(&r->core, samples, count, r->tick, late, events, &out, &frame);
    steps++;
    if (kind == GOOD || kind == FAULT || kind == WATCHDOG || kind == OLD_AND_NEW) {
        /* A jump that was believed while the speed was not known yet makes what comes next look like a jump. */
        /* An encoder that was wrong for longer than samples are held is not believed again before a reset. */
        const int lost = missing > r->core.config.hold_samples && (before == ERC_RUNNING || before == ERC_READY) &&
                         (frame.events & (ERC_THETA_DOUBTED | ERC_ALPHA_DOUBTED)) != 0u;
        must(r->core.missing == 0u || (frame.events & ERC_GLITCH) != 0u || lost, "a good sample counts");
        must(!lost || r->core.missing == missing + periods, "an encoder that is lost stays so");
    } else if (kind == NONE || kind == NOT_FINITE || resync == 0u) {
        must(r->core.missing == missing + periods || r->core.missing == 0u, "periods without a good sample count");
        must(kind == JUMP || r->core.missing != 0u, "what is no good sample does not count");
    }
    must(!(kind == DOUBLE && before == ERC_TRIPPED) || r->core.missing != 0u, "a rig that is stuck gives no sample");
    if (r->state == ERC_STARTING && r->core.missing == 0u) {
        r->state = ERC_RUNNING;
    }
    const int armed = r->state == ERC_RUNNING || r->state == ERC_READY;
    if (armed && (r->core.missing >= r->core.config.trip_samples || late > LATE_TRIP ||
                  (frame.events & (ERC_RIG_FAULT | ERC_RIG_WATCHDOG)) != 0u)) {
        r->state = ERC_TRIPPED;
    }
    must(kind != FAULT || !armed || r->state == ERC_TRIPPED, "a fault of the rig trips");
    must(r->core.state == r->state, "state after a step");
    must(!(before == ERC_TRIPPED && r->core.state != ERC_TRIPPED), "a trip holds until a reset");
    must(!(before == ERC_READY && r->core.state == ERC_RUNNING), "nothing moves until a program is run");
    check_output(r, &out, &frame);
    changes[before][r->core.state]++;
    r->field = out.field1 - out.field2;
}

static void end(rig *r) {
    erc_core_stop(&r->core);
    r->ending = 1u;
}

/* A core in a state, without samples for some periods: how it got there does not matter to what comes. */
static int arrive(rig *r, const erc_config *config, uint32_t state, uint32_t missing, uint32_t program) {
    erc_config own = *config;
    own.program = program;
    start(r, &own);
    for (int i = 0; i < 80 && state != ERC_STARTING; i++) {
        step(r, GOOD, 0, 1, 0);
    }
    if (state == ERC_TRIPPED || state == ERC_READY) {
        give(r, ZERO);
    }
    if (state == ERC_READY) {
        give(r, RESET);
    }
    for (uint32_t i = 0; i < missing; i++) {
        step(r, NONE, 0, 1, 0);
    }
    return r->core.state == state && r->core.missing == missing;
}

/* After the event, without any further sample: zero by the trip. With good ones: as the machine says. */
static void follow(rig r) {
    rig other = r;
    for (uint32_t i = 0; i < r.core.config.trip_samples + 2u; i++) {
        step(&r, NONE, 0, 1, 0);
        step(&other, GOOD, 0, 1, 0);
    }
    must(r.core.state != ERC_RUNNING && r.core.state != ERC_READY && r.field == 0.0, "zero by the trip");
}

static void all_pairs(const erc_config *config, uint32_t program) {
    static const uint64_t late[LATENESSES] = {0, PERIOD, LATE_TRIP + 1u}, slept[SLEPTS] = {1, 3, 40};
    static const uint32_t states[4] = {ERC_STARTING, ERC_RUNNING, ERC_TRIPPED, ERC_READY};
    for (uint32_t s = 0; s < 4u; s++) {
        const uint32_t state = states[s];
        for (uint32_t missing = 0; missing <= config->trip_samples + 1u; missing++) {
            rig there;
            if (!arrive(&there, config, state, missing, program)) {
                continue; /* no core is in this state after so many periods */
            }
            const int events = SAMPLES * ORDERS * LATENESSES * SLEPTS * ENDINGS;
            for (int e = 0; e < events; e++) {
                rig r = there;
                int rest = e;
                const enum sample kind = (enum sample)(rest % SAMPLES);
                rest /= SAMPLES;
                give(&r, (enum order)(rest % ORDERS));
                rest /= ORDERS;
                if (rest / (LATENESSES * SLEPTS) == ENDS) {
                    end(&r);
                }
                step(&r, kind, late[rest % LATENESSES], slept[rest / LATENESSES % SLEPTS], 0);
                follow(r);
                pairs++;
            }
        }
    }
}

static void random_sequences(const erc_config *config, unsigned long count) {
    rig r;
    start(&r, config);
    for (unsigned long i = 0; i < count; i++) {
        const unsigned long long chance = next() % 1000u;
        if (chance == 0u) {
            start(&r, config);
        } else if (chance < 20u) {
            give(&r, (enum order)(next() % ORDERS));
        } else if (chance < 60u) {
            give(&r, RESET);
            give(&r, next() % 4u != 0u ? PROGRAM : NO_ORDER);
        } else if (chance == 60u) {
            end(&r);
        }
        for (uint32_t k = 0; k < 64u; k++) {
            table[k] = (erc_row){any(), any(), any()};
        }
        const enum sample kind = next() % 8u != 0u ? GOOD : (enum sample)(next() % SAMPLES);
        const unsigned long lateness = next() % 400u, slept = next() % 200u;
        step(&r, kind, lateness == 0u ? LATE_TRIP + 1u : (lateness < 20u ? PERIOD : 0u),
             slept == 0u ? 30u : (slept < 10u ? 2u : 1u), (uint32_t)(next() & (ERC_BAD_PACKET | ERC_SEND_FAILED)));
    }
}

int main(int count, char **words) {
    const unsigned long sequences = count > 1 ? strtoul(words[1], 0, 10) : 100000u;
    const double rates[2] = {750.0, 20.0};
    for (uint32_t k = 0; k < 64u; k++) {
        table[k] = (erc_row){any(), any(), any()};
    }
    for (uint32_t i = 0; i < 4u; i++) {
        const erc_config config = config_of(i & 1u, i < 2u ? 5u : 0u, i < 2u ? 21u : 8u, rates[i / 2u], i);
        for (uint32_t program = 0; program < config.programs; program++) {
            all_pairs(&config, program);
        }
        random_sequences(&config, sequences);
    }
    printf("pairs %lu, steps %lu, broken %lu\n", pairs, steps, broken);
    for (uint32_t from = 0; from < 5u; from++) {
        printf("from %u:", from);
        for (uint32_t to = 0; to < 5u; to++) {
            printf(" %lu", changes[from][to]);
        }
        printf("\n");
    }
    return broken != 0u;
}
