/* From packets to angles and speeds: order, gaps, what can be, wraps, then the causal filter. */
#include "erc_sensors.h"

#include "erc_plausible.h"

#include <math.h>

#define LARGEST_GAP 1000u        /* samples; a sequence number further ahead is not believed */
#define WARM_UP 64u              /* samples before the speed is known well enough to reject a jump */
#define CLOCK_SLACK_NS 20000000u /* the rig's time stamps may be off the count of samples by this much */
#define STOPS 0.0625            /* of the largest jump in speed: no slower side is known to be stuck when it stops dead */
#define TURNED 2.0               /* times the speed with which a side came by which an end stop changes it */
#define BEHIND 0.46              /* most that a filter of a speed, damped by 1/sqrt(2), is behind a step, by its rate */
#define HALF 0.5
#define BY_COUNTS 2.0           /* counts that a quick filter takes for a speed */
#define SETTLES 0.25             /* periods that a filter may be behind after samples that were missing */
#define UNSURE 6u               /* periods after that in which torque and motion are not compared yet */
#define COUNTS 4.0               /* of an encoder: a side that is to have moved by fewer may stand on one of them */

/* Time passes without a reading. */
static void predict(erc_encoder *encoder, double dt, uint64_t periods) {
    encoder->position += dt * encoder->speed * (double)periods;
    encoder->since += periods;
}

/* A reading without whole wraps, as near to the prediction as it can be. */
static double unwrapped(const erc_encoder *encoder, double raw, double predicted, double *offset) {
    double x = raw + encoder->offset;
    *offset = encoder->offset;
    if (encoder->wrap > 0.0 && encoder->taken > 0u) {
        const double turns = nearbyint((predicted - x) / encoder->wrap);
        *offset += turns * encoder->wrap;
        x = raw + *offset;
    }
    return x;
}

/* Counts the periods in which a reading stays the same to the bit, and keeps the speed before them. */
static void watch(erc_encoder *encoder, double raw) {
    if (raw != encoder->reading) { /* NaN too */
        const double step = fabs(raw - encoder->reading);
        encoder->count = encoder->count > 0.0 && !(step < encoder->count) ? encoder->count : step;
        encoder->moving = encoder->speed;
        encoder->still = 0u;
    } else {
        encoder->still++;
    }
    encoder->reading = raw;
}

/* Whether an encoder reads the same while its side had to move: none stops dead from a speed, and stays to the bit, unless
 * its torque is large. That of a brake which closes is. */
static int stuck(const erc_core *core, const erc_encoder *encoder) {
    const double speed = fabs(encoder->moving), way = speed * core->dt * (double)ERC_STILL;
    const double counted = BY_COUNTS * core->config.filter_h * encoder->count / core->dt;
    const double limit = core->config.torque_limit;
    const double share = limit > 0.0 && isfinite(core->torque) ? fabs(core->torque) / limit : 0.0;
    return encoder->still >= ERC_STILL && encoder->glitch > 0.0 &&
           speed > (share > STOPS ? share : STOPS) * encoder->glitch && speed > counted &&
           way > COUNTS * encoder->count && encoder->taken >= WARM_UP;
}

static bool beyond_end(const erc_encoder *encoder, double x) {
    return encoder->end > 0.0 && fabs(x) > encoder->end;
}

/* By how much faster or slower than predicted a side can be. An end stop turns it, and the filter is late meanwhile: the
 * stop still pushes when the side has no speed any more. */
static double most_jump(const erc_core *core, const erc_encoder *encoder, double x, double predicted) {
    /* A reading that turns is off its prediction by so many periods of the change of the speed: by the last one, or by all
     * that a slow filter is behind. */
    const double slow = BEHIND / sqrt(core->config.filter_h);
    const double late = slow > 1.0 ? slow : 1.0;
    const bool stopped = beyond_end(encoder, predicted) && (x - predicted) * predicted < 0.0;
    return encoder->glitch + (stopped ? TURNED * encoder->came * late : 0.0);
}

/* As how many periods the time since the last reading counts. Where samples are missing, a side that speeds up is off by
 * the square of the time; and the filter finds back to it over several periods. */
static double as_periods(const erc_core *core, const erc_encoder *encoder, uint64_t periods) {
    const double missing = (double)(periods - 1u);
    return encoder->behind + (1.0 + missing) * (1.0 + HALF * core->config.filter_h * missing);
}

/* Why a reading cannot be; 0 if it can. The device cannot have moved so far since the last one, and no faster than it
 * ever moves while its speed is not known yet. */
static uint32_t impossible(const erc_core *core, const erc_encoder *encoder, double raw, uint64_t periods) {
    const double dt = core->dt;
    if (!isfinite(raw)) {
        return ERC_SAMPLE_INVALID;
    }
    double offset;
    const double predicted = encoder->position + dt * encoder->speed;
    const double x = unwrapped(encoder, raw, predicted, &offset);
    if (encoder->farthest > 0.0 && fabs(x) > encoder->farthest) {
        return ERC_OUT_OF_RANGE;
    }
    if (encoder->taken >= WARM_UP && encoder->glitch > 0.0 &&
        fabs(x - predicted) > most_jump(core, encoder, x, predicted) * dt * as_periods(core, encoder, periods)) {
        return ERC_GLITCH;
    }
    if (encoder->taken > 0u && encoder->fastest > 0.0 &&
        fabs(x - encoder->measured) > encoder->fastest * dt * (double)(encoder->since + 1u)) {
        return ERC_OUT_OF_RANGE;
    }
    return stuck(core, encoder) ? ERC_STUCK : 0u;
}

/* Take a reading: the recursion of LiveDerivative in signals/speed.py, term by term. After a gap the innovation has grown
 * over the whole gap, and the speed is corrected by what it is in one period. */
static uint32_t take(erc_encoder *encoder, double raw, double dt, double g, double h) {
    const double predicted = encoder->position + dt * encoder->speed;
    double offset;
    const double x = unwrapped(encoder, raw, predicted, &offset);
    const uint32_t events = offset == encoder->offset ? 0u : ERC_WRAP;
    encoder->offset = offset;
    encoder->measured = x;
    if (encoder->taken == 0u) {
        encoder->position = x;
        encoder->speed = 0.0;
    } else {
        const double innovation = x - predicted;
        encoder->position = predicted + g * innovation;
        encoder->speed += h * innovation / (dt * (double)(encoder->since + 1u));
    }
    if (!beyond_end(encoder, x) || fabs(encoder->speed) > encoder->came) {
        encoder->came = fabs(encoder->speed);
    }
    encoder->since = 0u;
    if (encoder->taken < WARM_UP) {
        encoder->taken++;
    }
    return events;
}

/* What is left of missing samples once a reading was taken: the filter forgets at least half of its gain of them. */
static void settle(const erc_core *core, erc_encoder *encoder, uint64_t periods) {
    encoder->behind = (1.0 - HALF * core->config.filter_g) * (as_periods(core, encoder, periods) - 1.0);
}

/* How many samples lie between the last one and this one; UINT64_MAX if it is not to be used. */
static uint64_t gap_before(erc_core *core, const erc_sample *sample, uint32_t *events) {
    const int repeated = core->state == ERC_TRIPPED && sample->seq == core->sensor_seq; /* a rig that is stuck */
    if (core->resync != 0u && !repeated) {
        core->resync = 0u;
        core->theta.taken = 0u;
        core->alpha.taken = 0u;
        return 0u;
    }
    if (sample->seq <= core->sensor_seq || sample->seq - core->sensor_seq > LARGEST_GAP) {
        *events |= ERC_STALE_PACKET;
        return UINT64_MAX;
    }
    const uint64_t counted = (sample->seq - core->sensor_seq) * core->config.period_ns;
    const uint64_t stamped = sample->time_ns - core->sensor_time; /* modulo 2^64: a jump back is a very long time */
    const uint64_t off = stamped > counted ? stamped - counted : counted - stamped;
    if (off > CLOCK_SLACK_NS) {
        *events |= ERC_CLOCK_JUMP; /* said, and nothing more: only the count is used */
    }
    return sample->seq - core->sensor_seq - 1u;
}

static uint32_t status_events(erc_core *core, uint32_t status) {
    uint32_t events = 0u;
    if ((status & ERC_STATUS_FAULT) != 0u) {
        events |= ERC_RIG_FAULT;
    }
    if ((status & ERC_STATUS_WATCHDOG) == 0u) {
        core->rig_seen = 1u;
    } else if (core->rig_seen != 0u) { /* before our first command it stands at zero as it should */
        events |= ERC_RIG_WATCHDOG;
    }
    return events;
}

static uint32_t torque_events(erc_core *core, double torque) {
    const uint32_t events = erc_torque_plausible(core, torque);
    core->torque = isfinite(torque) ? torque : (double)NAN;
    return isinf(torque) ? events | ERC_SAMPLE_INVALID : events;
}

/* One sample; sets *good if its angles were used. */
static uint32_t take_one(erc_core *core, const erc_sample *sample, int *good) {
    uint32_t events = 0u;
    const uint64_t gap = gap_before(core, sample, &events);
    if (gap == UINT64_MAX) {
        return events;
    }
    core->sensor_seq = sample->seq;
    core->sensor_time = sample->time_ns;
    events |= status_events(core, sample->status) | torque_events(core, sample->torque);
    predict(&core->theta, core->dt, gap);
    predict(&core->alpha, core->dt, gap);
    core->momentum.apart += core->momentum.apart < LARGEST_GAP ? (uint32_t)gap + 1u : 0u;
    watch(&core->theta, sample->theta);
    watch(&core->alpha, sample->alpha);
    const uint32_t theta = impossible(core, &core->theta, sample->theta, gap + 1u);
    const uint32_t alpha = impossible(core, &core->alpha, sample->alpha, gap + 1u);
    if (theta != 0u || alpha != 0u) {
        core->lost_by = theta | alpha | (theta != 0u ? ERC_THETA_DOUBTED : 0u) | (alpha != 0u ? ERC_ALPHA_DOUBTED : 0u);
    } else {
        const double g = core->config.filter_g, h = core->config.filter_h;
        const uint64_t unread = core->theta.since; /* periods in which nothing was read, of both sides */
        *good = 1;
        events |= take(&core->theta, sample->theta, core->dt, g, h);
        events |= take(&core->alpha, sample->alpha, core->dt, g, h);
        settle(core, &core->theta, gap + 1u);
        settle(core, &core->alpha, gap + 1u);
        if (unread > 0u || core->alpha.behind > SETTLES) { /* nobody knows the torque of those periods, or the speed yet */
            core->momentum.begun = false;
            core->momentum.unsure = UNSURE;
        }
        /* For each sample, and not once a step: of those that come together each is a period of its own. */
        return events | erc_momentum_plausible(core);
    }
    predict(&core->theta, core->dt, 1u);
    predict(&core->alpha, core->dt, 1u);
    return events | core->lost_by;
}

/* Whether an encoder has been wrong for so long that the field falls: then no later reading takes that back. Where the
 * angle was last seen to go, a wrong reading comes by sooner or later. */
static bool lost_for_good(const erc_core *core) {
    const bool doubted = (core->lost_by & (ERC_THETA_DOUBTED | ERC_ALPHA_DOUBTED)) != 0u;
    return doubted && core->missing > core->config.hold_samples &&
           (core->state == ERC_RUNNING || core->state == ERC_READY);
}

/* A doubt is a time: a meter that was wrong before a pause and is wrong after it was wrong meanwhile. */
static uint32_t with_pause(uint32_t before, uint32_t after, uint64_t pause) {
    const uint32_t least = before + (uint32_t)(pause < LARGEST_GAP ? pause : LARGEST_GAP);
    return before > 0u && after < least ? least : after;
}

/* The same for what the meter shows by itself. */
static void doubt_of_pause(erc_meter *m, uint32_t doubted, uint32_t alone, uint64_t pause) {
    if (m->wrong) {
        m->doubted = with_pause(doubted, m->doubted, pause);
    }
    if (m->wrong && (m->reason & ERC_DISAGREES) == 0u) {
        m->alone = with_pause(alone, m->alone, pause);
    }
}

/* All samples of a step. Counts periods in a row without a good one. */
uint32_t erc_sensors_take(erc_core *core, const erc_sample *samples, uint32_t count, uint64_t periods) {
    const uint32_t doubted = core->meter.wrong ? core->meter.doubted : 0u;
    const uint32_t alone = core->meter.wrong ? core->meter.alone : 0u;
    const uint64_t heard = core->sensor_seq;
    uint32_t events = 0u;
    int good = 0;
    core->momentum.before = core->momentum.doubted;
    erc_torque_expect(core, (uint32_t)(periods < LARGEST_GAP ? periods : LARGEST_GAP));
    for (uint32_t i = 0; i < count; i++) {
        events |= take_one(core, &samples[i], &good);
    }
    if (core->sensor_seq != heard) {
        doubt_of_pause(&core->meter, doubted, alone, core->step - core->heard);
        core->heard = core->step;
    }
    const bool lost = lost_for_good(core);
    if (good && !lost) {
        core->missing = 0u;
        return events;
    }
    if (lost) {
        events |= core->lost_by;
    } else if ((events & (ERC_THETA_DOUBTED | ERC_ALPHA_DOUBTED)) == 0u) {
        events |= ERC_SAMPLE_LOST;
        core->lost_by = ERC_SAMPLE_LOST;
    }
    core->missing = periods < UINT32_MAX - core->missing ? core->missing + (uint32_t)periods : UINT32_MAX;
    return events;
}
