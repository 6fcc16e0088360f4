/* Whether the sign of the torque sensor has turned. Such a torque may be within the band of the model and within dry
 * friction. But the last readings are then near the turned torque of the model, and far from that torque itself. */
#include "erc_turned.h"

#include <math.h>

#define LARGEST_TORQUE 1e9  /* N m: no model gives more */
#define TURNED_KNOWN 128u   /* readings after which the usual distance from the model is known */
#define OFFSET_BY 0.015625  /* share by which the usual offset from the model moves in a reading */
#define WILD 25.0           /* times that square: no single reading counts for more */
#define FAR_OFF 12.0        /* times that square: so far off the last readings are on average */
#define NEARER 12.0         /* times as near the turned torque. In health the most was 5 */

static double sum_of(const double *squares) {
    double sum = 0.0;
    uint32_t i;
    for (i = 0u; i < ERC_EARLIER; i++) {
        sum += squares[i];
    }
    return sum;
}

/* Learns the usual distance from a reading that leaves the last ones: so no fault makes itself usual in time. */
static void learn_usual(erc_turn *t, double least, double square) {
    const double most = WILD * (t->usual + least);
    const uint32_t known = t->readings - ERC_EARLIER + 1u; /* at most TURNED_KNOWN */
    const double counts = t->readings >= TURNED_KNOWN && square > most ? most : square;
    t->usual += (counts - t->usual) / (double)known;
}

bool erc_torque_turned(erc_core *core, double torque) {
    erc_turn *t = &core->meter.turn;
    const double model = core->meter.expected;
    const double expected = model + t->offset;
    const double least = core->meter.count * core->meter.count; /* a coarse sensor is off by that */
    if (!isfinite(core->estimate) || !(fabs(model) <= LARGEST_TORQUE)) {
        t->readings = 0u;
        t->offset = t->usual = 0.0;
        return false;
    }
    if (t->readings >= ERC_EARLIER) {
        learn_usual(t, least, t->off[t->place]);
    }
    t->off[t->place] = (torque - expected) * (torque - expected);
    t->turned[t->place] = (torque + expected) * (torque + expected);
    t->place = (t->place + 1u) % ERC_EARLIER;
    t->readings += t->readings < TURNED_KNOWN + ERC_EARLIER ? 1u : 0u;
    t->offset += OFFSET_BY * (torque - expected);
    if (t->readings < TURNED_KNOWN) {
        return false;
    }
    const double off = sum_of(t->off);
    return off > FAR_OFF * (double)ERC_EARLIER * (t->usual + least) && off > NEARER * sum_of(t->turned);
}
