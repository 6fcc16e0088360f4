/* What the last readings of the torque sensor tell together, where each by itself can be: within the band of the model and
 * within dry friction. A sign that has turned brings them near the turned torque of the model, and far from that torque
 * itself; less of that is enough while torque and motion nearly disagree, which is a second witness. And while the load
 * rests, another torque than before is further from the model's than it ever was there. Beside them stands when field, slip
 * and place tell a torque. */
#include "erc_turned.h"

#include <math.h>

#define LARGEST_TORQUE 1e9  /* N m: no model gives more */
#define TURNED_KNOWN 128u   /* readings after which the usual distance from the model is known */
#define OFFSET_BY 0.015625  /* share by which the usual offset from the model moves in a reading */
#define WILD 25.0           /* times that square: no single reading counts for more */
#define FAR_OFF 12.0        /* times that square: so far off the last readings are on average */
#define NEARER 12.0         /* times as near the turned torque. In health the most was 5 */
#define WITNESSED 3.5       /* each of both while torque and motion nearly disagree. In health the most was 1.2 */
#define RESTED 128u         /* readings of a load at rest under one field after which the usual distance is that of the rest */
#define FAR_AT_REST 7.0     /* times that square: so far off the last readings are on average. In health the most was 5 */
#define EACH_AT_REST 3.0    /* times that square: so far off is each of */
#define MOST_OF_REST 4u     /* readings among the last: no spike of a meter lasts so long */
#define LACKS 0.25          /* of the change of the model's torque: that much of it a device may lack */
#define HALF_OF_THEM 4u     /* the later half of the last readings, and the earlier one */
#define STEPS 16.0          /* times the usual square: such a step between both halves, and between their two readings.
                               In health the most was 5 */
#define RINGS_ON 0.9375     /* of the change of the model's torque, in a reading: a rotor rings for some time after it */
#define SLIPPED 24u         /* readings with a slip that tells the torque */
#define IN_TIME 3.0         /* readings by which a filter makes the speeds late, at most: the model's torque is later with it */
#define SIGNED 0.1          /* of the band: so much torque of the model has a sign */
#define VARIES_BY 0.0078125 /* share by which that usual square moves in a reading */

static double sum_of(const double *squares) {
    double sum = 0.0;
    uint32_t i;
    for (i = 0u; i < ERC_EARLIER; i++) {
        sum += squares[i];
    }
    return sum;
}

static uint32_t beyond(const double *squares, double limit) {
    uint32_t count = 0u, i;
    for (i = 0u; i < ERC_EARLIER; i++) {
        count += squares[i] > limit ? 1u : 0u;
    }
    return count;
}

/* The last ones are what this round has brought and the end of the round before: of that end the least and the largest
 * are known from each place on, once a round. So none is looked at again. */
void erc_torque_keep(erc_meter *m, double now) {
    const double expected = m->expected;
    const uint32_t next = m->place + 1u;
    if (m->place == 0u) {
        double low = m->earlier[ERC_EARLIER - 1u], high = low;
        uint32_t i;
        for (i = ERC_EARLIER - 1u; i > 0u; i--) {
            low = m->earlier[i] < low ? m->earlier[i] : low;
            high = m->earlier[i] > high ? m->earlier[i] : high;
            m->low_from[i] = low;
            m->high_from[i] = high;
        }
        m->lowest = m->highest = expected;
    }
    m->earlier[m->place] = expected;
    if (expected < m->lowest) {
        m->lowest = expected;
    }
    if (expected > m->highest) {
        m->highest = expected;
    }
    double low = now < m->lowest ? now : m->lowest;
    double high = now > m->highest ? now : m->highest;
    if (next < ERC_EARLIER) {
        low = m->low_from[next] < low ? m->low_from[next] : low;
        high = m->high_from[next] > high ? m->high_from[next] : high;
    }
    m->moved = high - low;
    m->place = next % ERC_EARLIER;
}

/* Learns the usual distance from a reading that leaves the last ones: so no fault makes itself usual in time. */
static void learn_usual(erc_turn *t, double least, double square) {
    const double most = WILD * (t->usual + least);
    const uint32_t known = t->readings - ERC_EARLIER + 1u; /* at most TURNED_KNOWN */
    const double counts = t->readings >= TURNED_KNOWN && square > most ? most : square;
    t->usual += (counts - t->usual) / (double)known;
}

/* Counts readings in a row of which each came a period after the last. Of others the model's torque is of another time. */
static void watch_time(erc_turn *t, uint64_t step) {
    if (step - t->step != 1u) {
        t->in_time = 0u;
    } else if (t->in_time < ERC_EARLIER) {
        t->in_time++;
    } else {
        /* all of the last ones */
    }
    t->step = step;
}

/* Whether a load rests, and the last readings are further from the model's torque than they ever were there. */
static bool differs_at_rest(erc_core *core, double usual, double withstands) {
    erc_turn *t = &core->meter.turn;
    const bool held = withstands > 0.0 && fabs(core->meter.expected) <= withstands;
    const bool rests = held && core->field * t->field > 0.0 && t->in_time > 0u;
    t->field = core->field;
    t->rested = rests ? t->rested + (t->rested < RESTED ? 1u : 0u) : 0u;
    if (t->rested < RESTED || beyond(t->off, EACH_AT_REST * usual) < MOST_OF_REST) {
        return false;
    }
    const double lacks = LACKS * core->meter.moved;
    return sum_of(t->off) > (double)ERC_EARLIER * (FAR_AT_REST * usual + lacks * lacks);
}

/* Learns what the distance from the model usually changes by between two readings that leave the last ones. */
static void learn_change(erc_turn *t, double least) {
    const double changed = t->apart[(t->place + 1u) % ERC_EARLIER] - t->apart[t->place];
    const double most = WILD * (t->varies + least), square = changed * changed;
    const bool known = t->readings >= TURNED_KNOWN;
    const uint32_t count = t->readings - ERC_EARLIER + 1u;
    const double by = known ? VARIES_BY : 1.0 / (double)count;
    t->varies += by * ((known && square > most ? most : square) - t->varies);
}

/* The later half of the last readings less the earlier half: by how much the meter has stepped beside the model. No more
 * than the one step between both halves: what comes bit by bit is no step. */
static double step_of(const erc_turn *t) {
    double later = 0.0, earlier = 0.0;
    uint32_t i;
    for (i = 0u; i < HALF_OF_THEM; i++) {
        earlier += t->apart[(t->place + i) % ERC_EARLIER];
        later += t->apart[(t->place + HALF_OF_THEM + i) % ERC_EARLIER];
    }
    const double step = fabs(later - earlier) / (double)HALF_OF_THEM;
    const uint32_t first = (t->place + HALF_OF_THEM) % ERC_EARLIER;
    const double at_once = fabs(t->apart[first] - t->apart[(first + ERC_EARLIER - 1u) % ERC_EARLIER]);
    return step < at_once ? step : at_once;
}

bool erc_slipping(const erc_core *core) {
    const double motor = core->theta.speed, output = core->alpha.speed, least = core->config.least_slip;
    const bool turned = core->config.device != ERC_SINGLE && !(core->field > 0.0); /* clutch 2, or neither */
    const bool second = !turned || fabs(motor + output) > least;
    const bool alone = turned && core->field < 0.0;
    return second && (alone || fabs(motor - output) > least);
}

bool erc_placed(const erc_core *core) {
    const double stroke = core->config.stroke;
    return !(stroke > 0.0) || fabs(core->alpha.measured) < stroke;
}

bool erc_speeds_in_time(const erc_core *core) {
    return core->momentum.g <= IN_TIME * core->momentum.h;
}

/* Whether all at once the meter reads another torque, and goes on so, while the model's has hardly moved. A torque follows
 * field and slip; with neither it does not step. */
static bool steps(erc_core *core, double least, bool slips) {
    erc_turn *t = &core->meter.turn;
    const bool tells = slips && core->field * t->field > 0.0 && t->in_time > 0u;
    const double moved = core->meter.moved;
    t->slipped = tells ? t->slipped + (t->slipped < SLIPPED ? 1u : 0u) : 0u;
    t->moved = moved > RINGS_ON * t->moved ? moved : RINGS_ON * t->moved;
    if (!erc_speeds_in_time(core) || t->slipped < SLIPPED || t->readings < TURNED_KNOWN || core->meter.guessed > 0u) {
        return false;
    }
    const double step = step_of(t) - t->moved; /* else it is the model that stepped, or a torque that the device lacks */
    return step > 0.0 && step * step > STEPS * (t->varies + least);
}

bool erc_torque_changed(erc_core *core, double torque, double withstands, bool slips) {
    erc_turn *t = &core->meter.turn;
    const double model = core->meter.expected;
    const double expected = model + t->offset;
    const double least = core->meter.count * core->meter.count; /* a coarse sensor is off by that */
    if (!isfinite(core->estimate) || !(fabs(model) <= LARGEST_TORQUE)) {
        t->readings = t->rested = t->in_time = t->slipped = 0u;
        t->offset = t->usual = t->varies = t->moved = 0.0;
        t->stepped = false;
        return false;
    }
    watch_time(t, core->step);
    if (t->readings >= ERC_EARLIER) {
        learn_usual(t, least, t->off[t->place]);
        learn_change(t, least);
    }
    t->apart[t->place] = torque - model;
    t->off[t->place] = (torque - expected) * (torque - expected);
    t->turned[t->place] = (torque + expected) * (torque + expected);
    t->place = (t->place + 1u) % ERC_EARLIER;
    t->readings += t->readings < TURNED_KNOWN + ERC_EARLIER ? 1u : 0u;
    t->offset += OFFSET_BY * (torque - expected);
    t->stepped = steps(core, least, slips);
    if (t->readings < TURNED_KNOWN || core->meter.guessed > 0u) { /* outside its log a model is no witness */
        return false;
    }
    const bool another = differs_at_rest(core, t->usual + least, withstands);
    const bool witness = core->momentum.nearly > 0u && t->in_time >= ERC_EARLIER;
    const double far_off = witness ? WITNESSED : FAR_OFF, nearer = witness ? WITNESSED : NEARER;
    const double off = sum_of(t->off);
    const bool far = off > far_off * (double)ERC_EARLIER * (t->usual + least);
    /* A sign that the model gives: the offset of a device turns with its clutch, and so may a torque of nearly nought. */
    const bool known = fabs(model) > fabs(t->offset) && fabs(model) > SIGNED * core->config.torque_band;
    return another || (far && known && off > nearer * sum_of(t->turned));
}
