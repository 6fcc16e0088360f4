#include "control.h"

#include "brake.h"

static brake_state state; /* all that the model remembers: its size is fixed, nothing is allocated */
static uint32_t flags;

uint32_t control_begin(void)
{
    return brake_reset(&state);
}

float control_tick(float field, float slip)
{
    brake_real input[BRAKE_INPUTS] = {0};
    brake_real effort;
    input[BRAKE_IN_FIELD] = field;
    input[BRAKE_IN_SLIP] = slip;
    flags = brake_step(&state, input, &effort);
    return effort; /* finite, whatever the sensors read */
}

uint32_t control_flags(void)
{
    return flags;
}
