/* Whether a measured torque can be: within the range of device and sensor, no faster than they are, alive, and as far
 * from the model's torque as device and model may differ. Who controls by it learns from no other reading. */
#include "erc_plausible.h"

#include <math.h>

#define MOST_PERIODS 1000u
#define UNLIKELY_SHARE 0.5 /* of the model's torque that a device may lack, or give beyond it */
#define HIGHEST_TORQUE 1e9 /* N m, where no limit is known */

static double distance(double a, double b) {
    return a > b ? a - b : b - a;
}

bool erc_slips(const erc_core *core) {
    const double motor = core->theta.speed, output = core->alpha.speed, least = core->config.least_slip;
    const double first = distance(motor, output), second = distance(-motor, output);
    if (core->config.device == ERC_SINGLE || core->field > 0.0) {
        return first > least;
    }
    return core->field < 0.0 ? second > least : first > least && second > least;
}

void erc_torque_expect(erc_core *core, uint32_t periods) {
    erc_meter *m = &core->meter;
    m->good = false;
    m->unlearn = false;
    m->since += m->since < MOST_PERIODS ? periods : 0u;
    if (isfinite(core->estimate)) {
        m->expected += core->stages.late_share * (core->estimate - m->expected);
        m->low = m->expected < m->low ? m->expected : m->low;
        m->high = m->expected > m->high ? m->expected : m->high;
    }
}

/* Whether the reading stays the same to the bit while the model's torque moves by what a live sensor must show. */
static bool stuck(const erc_config *config, const erc_meter *m) {
    return config->torque_still > 0.0 && m->still >= ERC_STILL && m->high - m->low > config->torque_still;
}

/* Why a reading alone cannot be; 0 if it can. */
static uint32_t impossible(const erc_core *core, double torque) {
    const erc_config *config = &core->config;
    const erc_meter *m = &core->meter;
    const double limit = config->torque_limit > 0.0 ? config->torque_limit : HIGHEST_TORQUE;
    if (!(fabs(torque) <= limit)) {
        return ERC_OUT_OF_RANGE;
    }
    if (config->torque_rate > 0.0 && m->seen &&
        fabs(torque - m->believed) > config->torque_rate * core->dt * (double)m->since) {
        return ERC_GLITCH;
    }
    return stuck(config, m) ? ERC_STUCK : 0u;
}

/* Whether a reading is further from the model's torque than device and model may differ; or, where an observer follows
 * the sensor, so far from what it has observed: a device drifts, it does not jump. */
static bool disagrees(const erc_core *core, double torque) {
    const double band = core->config.torque_band, expected = core->meter.expected;
    const erc_stages *s = &core->stages;
    if (!(band > 0.0) || !isfinite(core->estimate)) {
        return false;
    }
    const double observed = s->learned[s->side < 0.0].gain * expected + s->rest;
    const bool jumped = core->config.observer == ERC_BY_SENSOR && fabs(torque - observed) > band;
    return jumped || fabs(torque - expected) > band + UNLIKELY_SHARE * fabs(expected);
}

uint32_t erc_torque_plausible(erc_core *core, double torque) {
    erc_meter *m = &core->meter;
    m->good = false;
    if (isnan(torque)) { /* no reading: the model is in charge */
        m->still = 0u;
        m->reading = torque;
        return m->seen ? ERC_SAMPLE_INVALID : 0u;
    }
    if (torque == m->reading) {
        m->still = m->still < MOST_PERIODS ? m->still + 1u : m->still;
    } else {
        m->still = 0u;
        m->low = m->high = m->expected;
    }
    m->reading = torque;
    uint32_t reason = impossible(core, torque);
    const bool off = reason == 0u && disagrees(core, torque);
    if (off && core->field != 0.0 && erc_slips(core)) {
        reason = ERC_DISAGREES;
    }
    m->seen = true;
    if (reason != 0u) {
        m->unlearn = m->doubted == 0u && (reason == ERC_STUCK || reason == ERC_DISAGREES);
        m->doubted = m->doubted < MOST_PERIODS ? m->doubted + 1u : m->doubted;
        m->reason = ERC_TORQUE_DOUBTED | reason;
        return m->reason;
    }
    m->doubted = m->doubted > 0u ? m->doubted - 1u : 0u;
    m->believed = torque;
    m->since = 0u;
    m->good = !off; /* at one speed a clutch passes on whatever is asked of it: nothing follows from that */
    return 0u;
}
