/* For Frama-C's Eva: the interlock in a loop of unknown length, as the core calls it, asked for any bits. */
#include "erc_interlock.h"

#include "__fc_builtin.h"
#include <float.h>
#include <string.h>

#define LIMIT 0.5
#define MOTOR 0.95

volatile uint64_t source;

static double any(void) {
    double x;
    uint64_t bits = source;
    memcpy(&x, &bits, sizeof x);
    return x;
}

int main(void) {
    erc_config config;
    double field = 0.0, ask[3], out[3];
    memset(&config, 0, sizeof config);
    config.field_limit = LIMIT;
    config.motor_limit = MOTOR;
    while (source) {
        /* What erc_config_error() lets through. */
        config.period_ns = 100000u + source % 999900001u;
        config.rise_rate = Frama_C_double_interval(DBL_MIN, DBL_MAX);
        config.fall_rate = Frama_C_double_interval(DBL_MIN, DBL_MAX);
        config.stroke = Frama_C_double_interval(0.0, DBL_MAX);
        ask[0] = any();
        ask[1] = any();
        ask[2] = any();
        erc_interlock(&config, field, any(), any(), ask, out);
        /*@ check never_both: out[0] == 0.0 || out[1] == 0.0; */
        /*@ check first: \is_finite(out[0]) && 0.0 <= out[0] <= LIMIT; */
        /*@ check second: \is_finite(out[1]) && 0.0 <= out[1] <= LIMIT; */
        /*@ check motor: \is_finite(out[2]) && -MOTOR <= out[2] <= MOTOR; */
        field = out[0] - out[1];
    }
    return 0;
}
