/* Whether a measured torque can be: within the range of device and sensor, no faster than they are, alive, and as far
 * from the model's torque as device and model may differ. Who controls by it learns from no other reading. */
#include "erc_plausible.h"

#include "erc_turned.h"

#include <math.h>

#define MOST_PERIODS 1000000u
#define HALF 0.5

/* A reading alone. */
#define HIGHEST_TORQUE 1e9 /* N m, where no limit is known */
#define LIVELY 500u        /* readings after which it is known how often a sensor repeats itself */
#define MOST_REPEATED 16u  /* periods for which a sensor with noise does; a coarse one does so for as long as it likes */
#define REPEATS 2u         /* times its longest repetition after which a sensor is stuck */
#define COARSE 2.0         /* counts of a coarse sensor: a model's torque may move by so much and show none */

/* A reading beside the model's torque. */
#define DRIFTS 3.0         /* bands by which a device may drift off its model */
#define UNLIKELY_SHARE 0.5 /* and of the model's torque that it may lack, or give beyond it */
#define OPPOSED 0.5        /* of the band: a model's torque whose sign is known */
#define GUESSES 5.0        /* times its band by which a model is off outside its log */
#define GUESSED 100u       /* periods after that in which it still is: at the edge of its log a network is no better */
#define SURE 5u            /* periods of disagreement that no later agreement takes back */
#define SAYS_LITTLE 4u     /* readings inside the band that clear as much doubt as another one */

/* Torque beside motion. */
#define FASTEST 1e6         /* rad/s: no encoder that works reads more */
#define MOMENTUM_RATE 150.0 /* 1/s of the filter of both */
#define NEAR_REST 3.0       /* rad/s: dry friction is elastic, and turns only some way after the motion has */
#define BREAKS_AWAY 1.2     /* times its sliding friction that an output at rest withstands */
#define STANDS 0.02         /* rad/s: between two counts of an encoder */
#define STOOD_STILL 32u     /* periods at rest after which nothing rings or is late any more */
#define AT_REST 0.3         /* of the band, at such a rest */
#define OFF_SHARE 0.35      /* of the torque by which the inertia may be off: a torque that is doubled lacks half */
#define MOTOR_SHARE 0.3     /* of the motor's torque: a tenth of that may be off */
#define MOTOR_LAGS 6.0      /* of its change: that may pass before the speed shows it */
#define SLOW 20.0           /* times the least slip: up to there a drive's viscous drag is less than its dry friction */
#define NEARLY 0.65         /* of what they may: so far apart they are a second witness of what the meter tells */
#define NEARLY_FOR 4u       /* periods */
#define MOMENTUM_SURE 1u    /* periods of doubt after which the field falls at once, whatever follows, and twice as fast */
#define MOMENTUM_LITTLE 16u /* agreements that say little and clear as much doubt as another one */

/* What dry friction takes of the torque of a load at rest. */
#define CREEPS 1.0           /* rad/s: by a count now and then a load at rest creeps on */
#define RINGS 12u            /* periods after such a count */
#define HELD_BY 0.125        /* share by which the usual friction moves in a period */
#define SCATTERS_BY 0.015625 /* and its usual distance from that */
#define CALM 64u             /* periods after which both are known */
#define STEADY 0.01          /* of the field limit: no change in a period */
#define JUMPS 16.0           /* times the usual distance: noise is never so far off */
#define JUMP_COUNTS 2.0      /* counts of the meter */
#define JUMP_LAGS 2.0        /* of the change of the motor's torque */
#define JUMPED 4u            /* periods in a row, which are no spike of a meter */

double erc_held_share(uint32_t hold, uint32_t trip, uint32_t periods) {
    const double held = (double)hold, none = (double)trip - (double)ERC_ZERO_BEFORE_TRIP, wrong = (double)periods;
    if (wrong <= held) {
        return 1.0;
    }
    return wrong < none ? (none - wrong) / (none - held) : 0.0;
}

double erc_at_most(double x, double most) {
    return isfinite(x) && x <= most ? x : most;
}

void erc_torque_expect(erc_core *core, uint32_t periods) {
    erc_meter *m = &core->meter;
    m->good = m->unlearn = false;
    if (m->since < MOST_PERIODS) {
        m->since += periods;
    }
    if (isfinite(core->estimate)) {
        m->expected += core->stages.late_share * (core->estimate - m->expected);
        const bool guess = m->guessed > 0u; /* that tells no sensor what to show */
        if (guess || m->expected < m->low) {
            m->low = m->expected;
        }
        if (guess || m->expected > m->high) {
            m->high = m->expected;
        }
        erc_torque_keep(m, core->estimate);
    }
}

void erc_torque_guess(erc_core *core, bool outside) {
    erc_meter *m = &core->meter;
    m->guessed = outside ? GUESSED : (m->guessed > 0u ? m->guessed - 1u : 0u);
}

/* Counts how long the reading has been the same to the bit, and how long a good sensor ever was. */
static void watch(erc_meter *m, double torque) {
    const bool same = torque == m->reading;
    if (same) {
        m->still += m->still < MOST_PERIODS ? 1u : 0u;
    }
    /* Of its first readings each counts, later ones where it was not stuck. */
    if (m->still > m->longest && (m->readings < LIVELY || (!same && m->doubted == 0u))) {
        m->longest = m->still;
    }
    if (!same) {
        const double step = fabs(torque - m->reading); /* NaN at first */
        if (step < m->count || !(m->count > 0.0)) {
            m->count = step;
        }
        m->still = 0u;
        m->low = m->high = m->expected;
    }
    m->readings += m->readings < LIVELY ? 1u : 0u;
    m->reading = torque;
}

/* Whether the sensor repeats itself for longer than it ever did; or while the model's torque moves by what a live sensor
 * must show. */
static bool stuck(const erc_config *config, const erc_meter *m) {
    const double way = m->high - m->low;
    const bool shows = way > config->torque_still && !(way <= COARSE * m->count); /* NaN: no count is known yet */
    const bool moves = config->torque_still > 0.0 && shows;
    const bool noisy = m->readings >= LIVELY && m->longest <= MOST_REPEATED;
    const bool lively = config->torque_still > 0.0 && noisy && m->still > REPEATS * m->longest;
    return m->still >= ERC_STILL && (moves || lively);
}

/* Why a reading alone cannot be; 0 if it can. */
static uint32_t impossible(const erc_core *core, double torque) {
    const erc_config *config = &core->config;
    const erc_meter *m = &core->meter;
    const double limit = config->torque_limit > 0.0 ? config->torque_limit : HIGHEST_TORQUE;
    if (!isfinite(torque) || torque < -limit || torque > limit) {
        return ERC_OUT_OF_RANGE;
    }
    const double periods = m->since > 0u ? (double)m->since : 1.0; /* two samples may come in one step */
    const bool far = fabs(torque - m->believed) > config->torque_rate * core->dt * periods; /* in health never */
    if (far && config->torque_rate > 0.0 && m->seen) {
        return ERC_GLITCH;
    }
    return stuck(config, m) ? ERC_STUCK : 0u;
}

/* Whether a reading is further from the model's torque than device and model may differ; or, where an observer follows
 * the sensor, so far from what it has observed: a device drifts, it does not jump. */
static bool disagrees(const erc_core *core, double torque) {
    const bool guess = core->meter.guessed > 0u || !erc_speeds_in_time(core); /* a clutch may have locked long ago */
    const double band = core->config.torque_band * (guess ? GUESSES : 1.0);
    const double expected = core->meter.expected;
    const erc_stages *s = &core->stages;
    if (!(band > 0.0) || !isfinite(core->estimate)) {
        return false;
    }
    const double rings = core->meter.moved;
    const bool follows = core->config.observer == ERC_BY_SENSOR && core->step - s->step <= 1u;
    if (follows) {
        const double observed = s->learned[s->side < 0.0].gain * expected + s->rest;
        if (fabs(torque - observed) > band + rings) {
            return true; /* jumped */
        }
    }
    const double off = fabs(torque - expected);
    if (off <= band) { /* as in health: then it opposes by less than that, too */
        return false;
    }
    const bool opposes = torque * expected < 0.0 && fabs(expected) > OPPOSED * band && fabs(torque) > band + rings;
    return opposes || off > DRIFTS * band + rings + UNLIKELY_SHARE * fabs(expected);
}

/* A good reading takes doubt away. While the model's torque is within its band each reading agrees with it: such a
 * reading says little. Once doubt takes the field down it takes the disagreement along: then no reading counts any more. */
static void clear(erc_core *core) {
    erc_meter *m = &core->meter;
    const bool disagreed = (m->reason & ERC_DISAGREES) != 0u;
    const bool says = !disagreed || fabs(m->expected) > core->config.torque_band;
    if (disagreed && m->doubted > SURE) {
        m->doubted += m->doubted < MOST_PERIODS ? 1u : 0u;
        return;
    }
    m->little = says ? SAYS_LITTLE : m->little + 1u;
    if (m->doubted > 0u && m->little >= SAYS_LITTLE) {
        m->doubted--;
    }
    m->little %= SAYS_LITTLE;
}

/* The side whose momentum is compared: the output of a pair, which the measured torque moves; the drive of a single
 * device at rest, which the motor moves against the measured torque. */
static double speed_of_load(const erc_core *core) {
    return core->config.device == ERC_SINGLE ? core->theta.speed : core->alpha.speed;
}

/* What dry friction holds of the measured torque: none of it where the load moves or anything else acts on it. */
static double withstood(const erc_core *core) {
    const bool rests = core->config.load_inertia > 0.0 && fabs(speed_of_load(core)) <= CREEPS;
    return rests ? BREAKS_AWAY * core->config.load_friction : 0.0;
}

uint32_t erc_torque_plausible(erc_core *core, double torque) {
    erc_meter *m = &core->meter;
    uint32_t reason;
    bool off, changed;
    m->good = m->wrong = m->turn.stepped = false;
    if (!isfinite(torque) && !(fabs(torque) > HIGHEST_TORQUE)) { /* no reading: the model is in charge */
        m->still = 0u;
        m->reading = torque;
        return m->seen ? ERC_SAMPLE_INVALID : 0u;
    }
    watch(m, torque);
    reason = impossible(core, torque);
    const double can_be = reason == 0u ? torque : m->believed; /* whatever follows, nothing beyond the limit is believed */
    const bool slips = erc_slipping(core) && erc_placed(core);
    changed = reason == 0u && erc_torque_changed(core, torque, withstood(core), slips);
    off = changed || (reason == 0u && disagrees(core, torque));
    /* At its end stop the output stops what turns with it: the meter reads that, and no model knows it. */
    if (off && core->field != 0.0 && slips) {
        reason = ERC_DISAGREES;
        m->doubted = changed && m->doubted < SURE ? SURE : m->doubted; /* several readings have said so */
    }
    m->seen = true;
    if (reason != 0u && reason != ERC_DISAGREES) {
        m->alone += m->alone < MOST_PERIODS ? 1u : 0u;
    } else {
        m->alone -= m->alone > 0u ? 1u : 0u;
    }
    if (reason != 0u) {
        m->wrong = true;
        m->unlearn = m->unlearn || (m->doubted == 0u && (reason == ERC_STUCK || reason == ERC_DISAGREES));
        m->doubted += m->doubted < MOST_PERIODS ? 1u : 0u;
        m->reason = ERC_TORQUE_DOUBTED | reason;
        return m->reason;
    }
    clear(core);
    m->believed = can_be;
    m->since = 0u;
    m->good = !off; /* at one speed a clutch passes on whatever is asked of it: nothing follows from that */
    return 0u;
}

static double torque_on_load(const erc_core *core) {
    return core->config.device == ERC_SINGLE ? core->driven - core->torque : core->torque;
}

/* Of this a share may be off: for the inertia that takes so much torque, for the drag, for the scale of the motor's
 * torque, and for its lag where it changes. */
static double uncertain(const erc_core *core, double taken) {
    const erc_momentum *m = &core->momentum;
    if (core->config.device != ERC_SINGLE) {
        return fabs(taken) + m->rings + core->config.load_drag * fabs(speed_of_load(core));
    }
    return fabs(taken) + MOTOR_SHARE * fabs(core->driven) + MOTOR_LAGS * fabs(core->driven - m->driven);
}

/* What is left of a torque after the friction of that side; *rests: how much of the dry friction rests. */
static double less_friction(const erc_core *core, double torque, double *rests) {
    const double way = tanh(speed_of_load(core) / NEAR_REST);
    *rests = 1.0 - fabs(way);
    return torque - core->config.load_friction * way - core->config.load_drag * speed_of_load(core);
}

/* The torque in this period, as late as the speed that it changes: through the filter of that speed. Where it rings to and
 * fro from period to period, it may be as far off between two readings. */
static void delay(erc_momentum *m, double torque) {
    const double changed = torque - m->torque;
    const double late = (2.0 - m->g - m->h) * m->late[0] - (1.0 - m->g) * m->late[1] + m->h * HALF * (torque + m->torque);
    m->late[1] = m->late[0];
    m->late[0] = late;
    m->torque = torque;
    m->rings = changed * m->changed < 0.0 ? erc_at_most(fabs(changed), fabs(m->changed)) : 0.0;
    m->changed = changed;
}

/* The filtered torque less what the filtered speed of that side has taken of it in this period. */
static double unbalanced(erc_core *core) {
    erc_momentum *m = &core->momentum;
    const double by = MOMENTUM_RATE * core->dt, moves = by / (1.0 + by);
    double rests;
    const double passed = less_friction(core, m->late[0], &rests);
    const double faster = moves * (speed_of_load(core) - m->speed);
    const double taken = core->config.load_inertia * faster / core->dt;
    m->speed += faster;
    m->passed += moves * (passed - m->passed);
    m->size += moves * (uncertain(core, taken) - m->size);
    m->rests += moves * (rests - m->rests);
    m->driven += moves * (core->driven - m->driven);
    return m->passed - taken;
}

/* Beyond this the friction of a load at rest is another one. */
static double most_off_at_rest(const erc_core *core) {
    const erc_momentum *m = &core->momentum;
    const double rest = AT_REST * core->config.load_band;
    const double usual = JUMPS * m->scatter;
    const double counts = JUMP_COUNTS * core->meter.count;
    const double late = JUMP_LAGS * fabs(core->driven - m->driven);
    return (rest > usual ? rest : usual) + counts + late;
}

/* Whether a load at rest is held by another friction than before, all at once, while neither field nor motor changes. No
 * friction jumps so: the meter is another. */
static bool jumps(erc_core *core) {
    erc_momentum *m = &core->momentum;
    const double friction = torque_on_load(core);
    const double off = fabs(friction - m->held);
    const bool steady = fabs(core->field - m->field) <= STEADY * core->config.field_limit;
    const bool moves = fabs(speed_of_load(core)) > CREEPS;
    m->field = core->field;
    if (!steady || moves) { /* what was known of a rest says nothing of the next one */
        m->calm = 0u;
        m->scatter = 0.0;
    }
    if (!steady || m->stands < RINGS) {
        m->held = friction;
        m->jumped = 0u;
        return false;
    }
    if (m->calm >= CALM && off > most_off_at_rest(core)) {
        m->jumped++;
        return true;
    }
    m->calm += m->calm < CALM ? 1u : 0u;
    m->jumped = 0u;
    m->held += HELD_BY * (friction - m->held);
    m->scatter += SCATTERS_BY * (off - m->scatter);
    return false;
}

/* Agreement takes doubt away, unless the field already falls. Of a small torque half would not be missed: agreement on it
 * says little. */
static void agree(erc_momentum *m, bool says) {
    m->little += says ? MOMENTUM_LITTLE : 1u;
    if (m->little >= MOMENTUM_LITTLE) {
        m->little = 0u;
        m->doubted -= m->doubted > 0u ? 1u : 0u;
    }
}

uint32_t erc_momentum_doubts(const erc_core *core) {
    const uint32_t encoder = core->config.device == ERC_SINGLE ? ERC_THETA_DOUBTED : ERC_ALPHA_DOUBTED;
    (void)core; /* an exported controller is of one device */
    return ERC_TORQUE_DOUBTED | encoder | ERC_DISAGREES;
}

uint32_t erc_momentum_periods(const erc_core *core, uint32_t hold) {
    const uint32_t doubted = core->momentum.doubted;
    return doubted > MOMENTUM_SURE ? doubted - MOMENTUM_SURE + hold : doubted;
}

/* Whether the torque is known, and nothing but friction acts beside it: there an end stop does. */
static bool has_witness(const erc_core *core) {
    const erc_config *config = &core->config;
    if (!(config->load_inertia > 0.0) || !erc_placed(core)) {
        return false; /* not compared */
    }
    const double limit = config->torque_limit > 0.0 ? config->torque_limit : HIGHEST_TORQUE;
    const bool known = fabs(core->torque) <= limit && fabs(speed_of_load(core)) <= FASTEST;
    const bool alone = core->meter.wrong && (core->meter.reason & ERC_DISAGREES) == 0u; /* wrong by itself */
    return known && !alone;
}

/* The first sample of a comparison: nothing has changed yet. */
static void begin(erc_core *core) {
    erc_momentum *m = &core->momentum;
    m->begun = true;
    m->speed = speed_of_load(core);
    m->torque = m->late[0] = m->late[1] = torque_on_load(core);
    m->passed = 0.0;
    m->rests = m->changed = m->rings = 0.0;
    m->driven = core->driven;
    m->size = uncertain(core, 0.0);
    m->stands = 0u;
}

/* By how much torque and motion may differ. */
static double most_off(const erc_core *core) {
    const erc_momentum *m = &core->momentum;
    const double band = (m->stands < STOOD_STILL ? 1.0 : AT_REST) * core->config.load_band;
    const double rest = BREAKS_AWAY * core->config.load_friction * m->rests;
    const double counted = core->meter.count > 0.0 ? HALF * core->meter.count : 0.0; /* NaN: none is known yet */
    return band + counted + rest + OFF_SHARE * m->size;
}

/* One more period of doubt. Where missing samples were why nothing was compared, meter or encoder has been wrong since. */
static void doubt(erc_core *core, uint32_t apart) {
    erc_momentum *m = &core->momentum;
    core->meter.good = false;
    core->meter.unlearn = core->meter.unlearn || m->doubted == 0u;
    m->unseen = m->doubted == 0u ? apart : m->unseen;
    m->doubted++;
    if (m->doubted > MOMENTUM_SURE && m->unseen > 1u) {
        m->doubted += m->unseen;
    }
}

uint32_t erc_momentum_plausible(erc_core *core) {
    const uint32_t either = erc_momentum_doubts(core);
    erc_momentum *m = &core->momentum;
    if (m->doubted > MOMENTUM_SURE) { /* no agreement takes that back: one that is doubled agrees whenever it is small */
        m->doubted += m->doubted < MOST_PERIODS ? 2u : 0u;
        core->meter.good = false;
        return either;
    }
    if (m->nearly > 0u) {
        m->nearly--;
    }
    if (!has_witness(core)) {
        m->begun = false;
        m->doubted = m->apart = 0u; /* a meter that is known to be wrong is who disagreed */
        return 0u;
    }
    if (!m->begun) {
        begin(core);
        return 0u;
    }
    delay(m, torque_on_load(core));
    const double off = fabs(unbalanced(core));
    const bool stands = fabs(speed_of_load(core)) <= STANDS;
    m->stands = stands ? m->stands + (m->stands < STOOD_STILL ? 1u : 0u) : 0u;
    const bool slow = fabs(speed_of_load(core)) <= SLOW * core->config.least_slip;
    if (core->config.device == ERC_SINGLE && !slow) {
        m->doubted = m->apart = 0u; /* drags of bearings and gears are not known */
        return 0u;
    }
    if (m->unsure > 0u) { /* of torque and speed each was begun at a value that nobody knows to be the usual one */
        m->unsure--;
        return 0u;
    }
    const uint32_t apart = m->apart;
    m->apart = 0u;
    if (jumps(core)) {
        core->meter.good = false;
        core->meter.unlearn = core->meter.unlearn || m->jumped == 1u;
        m->doubted = m->jumped < JUMPED ? m->doubted : MOMENTUM_SURE + 1u;
        return m->jumped < JUMPED ? 0u : either;
    }
    if (core->meter.turn.stepped) { /* several readings have said so */
        core->meter.good = false;
        core->meter.unlearn = true;
        m->doubted = MOMENTUM_SURE + 1u;
        return either;
    }
    const double may = most_off(core);
    m->nearly = off > NEARLY * may ? NEARLY_FOR : m->nearly;
    if (!(off > may)) {
        agree(m, HALF * m->size > may);
        return 0u;
    }
    doubt(core, apart);
    return either;
}
