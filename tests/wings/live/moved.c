/* By how much the model's torque has moved in its last periods, as the loop keeps it, beside a search through all of them:
 * of torques that rise, fall, swing, jump, stay and are drawn at random. Prints what it compared. */
#include "erc_turned.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define PERIODS 20000u

static double drawn(unsigned long *state) {
    *state = (*state * 6364136223846793005ul + 1442695040888963407ul) & 0xfffffffffffffffful;
    return (double)(*state >> 33) / 2147483648.0 - 0.5;
}

static double torque_of(unsigned way, unsigned k, unsigned long *state) {
    switch (way) {
    case 0u:
        return 1e-3 * k;
    case 1u:
        return -1e-3 * k;
    case 2u:
        return sin(0.05 * k);
    case 3u:
        return k / 13u % 2u ? 1.0 : -1.0;
    case 4u:
        return 0.25;
    default:
        return drawn(state);
    }
}

int main(void) {
    unsigned long steps = 0, broken = 0, state = 1;
    for (unsigned way = 0; way < 6u; way++) {
        erc_meter meter;
        double last[ERC_EARLIER] = {0.0};
        memset(&meter, 0, sizeof meter);
        for (unsigned k = 0; k < PERIODS; k++, steps++) {
            const double now = torque_of(way, k + 1u, &state);
            double low = now, high = now;
            meter.expected = last[k % ERC_EARLIER] = torque_of(way, k, &state);
            erc_torque_keep(&meter, now);
            for (unsigned i = 0; i < ERC_EARLIER; i++) {
                low = fmin(low, last[i]);
                high = fmax(high, last[i]);
            }
            broken += meter.moved != high - low;
        }
    }
    printf("pairs 6, steps %lu, broken %lu\n", steps, broken);
    return broken > 0;
}
