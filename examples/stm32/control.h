/* One period of a controller, the same file on an STM32 and under QEMU. */
#ifndef CONTROL_H
#define CONTROL_H

#include <stdint.h>

/* Once, before the timer starts. 0, or BRAKE_INEXACT where the compiler's options changed the arithmetic. */
uint32_t control_begin(void);

/* In the timer's interrupt: the effort that the device gives now, in the model's unit. */
float control_tick(float field, float slip);

/* What the last period said: 0, or flags of brake.h, such as BRAKE_OUTSIDE_RANGE. */
uint32_t control_flags(void);

#endif
