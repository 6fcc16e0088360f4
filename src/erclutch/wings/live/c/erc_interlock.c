/* The last stage before the rig, whatever control asked for: finite, within limits, never both fields, not outward at
 * the end of the stroke, not faster than the supply. */
#include "erc_interlock.h"

#include <math.h>

static double finite_or_zero(double value, uint32_t *events) {
    if (isfinite(value)) {
        return value;
    }
    *events |= ERC_COMMAND_NOT_FINITE;
    return 0.0;
}

static double clipped(double value, double low, double high, uint32_t *events) {
    if (value < low || value > high) {
        *events |= ERC_BEYOND_LIMIT;
        return value < low ? low : high;
    }
    return value;
}

/* The signed field that the supply can reach in one period, on its way from `previous` to `wanted`. */
static double reachable(double previous, double wanted, double rise, double fall) {
    const double way = previous < 0.0 ? -1.0 : 1.0;
    const double from = way * previous, to = way * wanted;
    const double least = from - fall, most = from + rise;
    if (least > 0.0 && to < least) {
        return way * least;
    }
    if (to < 0.0) { /* through zero to the other clutch */
        return way * (to < -rise ? -rise : to);
    }
    return way * (to > most ? most : to);
}

uint32_t erc_interlock(const erc_config *config, double previous, double alpha, double theta_dot, const double ask[3],
                       double out[3]) {
    uint32_t events = 0u;
    const double dt = 1e-9 * (double)(uint32_t)config->period_ns; /* at most 1 s; 64 bits are dear on a small processor */
    double first = clipped(finite_or_zero(ask[0], &events), 0.0, config->field_limit, &events);
    double second = clipped(finite_or_zero(ask[1], &events), 0.0, config->field_limit, &events);
    if (first > 0.0 && second > 0.0) {
        events |= ERC_BOTH_FIELDS;
        if (first >= second) {
            second = 0.0;
        } else {
            first = 0.0;
        }
    }
    double wanted = first - second;
    /* Clutch 1 drives the output the way that the motor turns. */
    const double drive = theta_dot < 0.0 ? -wanted : wanted;
    if (config->stroke > 0.0 && ((alpha > config->stroke && drive > 0.0) || (alpha < -config->stroke && drive < 0.0))) {
        events |= ERC_GUARD;
        wanted = 0.0;
    }
    const double field = reachable(previous, wanted, config->rise_rate * dt, config->fall_rate * dt);
    if (fabs(field - wanted) > 1e-12) {
        events |= ERC_RATE_LIMITED;
    }
    out[0] = field > 0.0 ? field : 0.0;
    out[1] = field < 0.0 ? -field : 0.0;
    out[2] = clipped(finite_or_zero(ask[2], &events), -config->motor_limit, config->motor_limit, &events);
    return events;
}
