/* A board of QEMU in place of the STM32: SysTick is the timer, the test vectors are the sensors, semihosting the printer.

   On an STM32 the Cube's start-up file, HAL_TIM_PeriodElapsedCallback and your drivers stand here. */
#include <stdint.h>
#include <string.h>

#include "brake.h"
#include "brake_vectors.h"
#include "control.h"

extern uint32_t top_of_stack, load_of_data, begin_of_data, end_of_data, begin_of_bss, end_of_bss;
void start(void);

#define CLOCK 25000000u /* Hz, of the board */
#define PERIOD (CLOCK / 1000u) /* [SysTick counts] of 1 kHz */
#define TICK_CONTROL (*(volatile uint32_t *)0xE000E010)
#define TICK_RELOAD (*(volatile uint32_t *)0xE000E014)
#define TICK_NOW (*(volatile uint32_t *)0xE000E018)

static volatile uint32_t row; /* of the vectors; one a period */
static uint32_t same;         /* rows in which effort and flags are those of the vectors, to the bit */
static uint32_t longest;      /* [SysTick counts] the longest period's work */

static void semihost(long operation, const void *argument)
{
    register long r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
}

static void leave(uint32_t code)
{
    const uint32_t block[2] = {0x20026u, code};
    semihost(0x20, block);
    for (;;)
    {
    }
}

static void say(const char *word, uint32_t value)
{
    char line[48];
    char *p = line;
    uint32_t power = 1000000000u;
    while (*word != '\0')
    {
        *p++ = *word++;
    }
    while (power > 1u && value / power == 0u)
    {
        power /= 10u;
    }
    for (; power > 0u; power /= 10u)
    {
        *p++ = (char)('0' + (value / power) % 10u);
    }
    *p++ = '\n';
    *p = '\0';
    semihost(0x04, line);
}

static void fault(void)
{
    semihost(0x04, "FAULT\n");
    leave(2u);
}

/* The timer interrupt: read, estimate, compare. */
static void tick(void)
{
    float read[BRAKE_INPUTS];
    float effort;
    uint32_t before;
    uint32_t after;
    uint32_t took;
    if (row >= STEPS)
    {
        return;
    }
    memcpy(read, steps[row], sizeof read);
    before = TICK_NOW;
    effort = control_tick(read[BRAKE_IN_FIELD], read[BRAKE_IN_SLIP]);
    after = TICK_NOW;
    took = (before >= after) ? before - after : before + PERIOD - after; /* the timer counts down, from zero anew */
    longest = (took > longest) ? took : longest;
    same += (memcmp(&effort, &steps[row][BRAKE_INPUTS], sizeof effort) == 0 && control_flags() == step_flags[row]) ? 1u : 0u;
    row++;
}

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    &top_of_stack, (const void *)start, (const void *)fault, (const void *)fault, (const void *)fault,
    (const void *)fault, (const void *)fault, 0, 0, 0, 0, (const void *)fault, 0, 0, (const void *)fault,
    (const void *)tick};

void start(void)
{
    const uint32_t *from = &load_of_data;
    uint32_t *to;
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20; /* floating-point unit on */
    __asm__ volatile("dsb\n isb");
    for (to = &begin_of_data; to < &end_of_data;)
    {
        *to++ = *from++;
    }
    for (to = &begin_of_bss; to < &end_of_bss;)
    {
        *(volatile uint32_t *)to++ = 0u;
    }
    if (control_begin() != 0u)
    {
        semihost(0x04, "INEXACT: a compiler option such as -ffast-math changed the arithmetic\n");
        leave(3u);
    }
    TICK_RELOAD = PERIOD - 1u;
    TICK_NOW = 0u;
    TICK_CONTROL = 7u; /* on, with its interrupt, from the processor's clock */
    while (row < STEPS)
    {
        __asm__ volatile("wfi");
    }
    say("periods of 1 ms: ", row);
    say("the same to the bit: ", same);
    say("instructions of the longest: ", longest * (1000000000u / CLOCK)); /* QEMU: one a nanosecond */
    say("bytes of state: ", (uint32_t)sizeof(brake_state));
    leave(same == STEPS ? 0u : 1u);
}
