/* Test bench on bare metal: results by semihosting, instructions by SysTick, stack by paint. */
#include <stdint.h>
#include <string.h>

#include HEADER
#include VECTORS

extern uint32_t top_of_stack, load_of_data, begin_of_data, end_of_data, begin_of_bss, end_of_bss;
void start(void);

#define PAINT 0xA5A5A5A5u
#define PAINTED 4096u /* words below the stack pointer */
#ifndef REPEATS
#define REPEATS 8u
#endif

static long semihost(long operation, const void *argument)
{
    register long r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void leave(uint32_t code)
{
    const uint32_t block[2] = {0x20026u, code};
    (void)semihost(0x20, block);
    for (;;)
    {
    }
}

static void fault(void)
{
    (void)semihost(0x04, "FAULT\n");
    leave(2u);
}

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    &top_of_stack, (const void *)start, (const void *)fault, (const void *)fault, (const void *)fault,
    (const void *)fault, (const void *)fault, 0, 0, 0, 0, (const void *)fault, 0, 0, (const void *)fault,
    (const void *)fault};

static char *decimal(char *p, uint32_t value)
{
    char digits[12];
    int n = 0;
    do
    {
        digits[n++] = (char)('0' + (value % 10u));
        value /= 10u;
    } while (value != 0u);
    while (n > 0)
    {
        *p++ = digits[--n];
    }
    return p;
}

static void say(const char *word, uint32_t value)
{
    char line[40];
    char *p = line;
    while (*word != '\0')
    {
        *p++ = *word++;
    }
    *p++ = ' ';
    p = decimal(p, value);
    *p++ = '\n';
    *p = '\0';
    (void)semihost(0x04, line);
}

static void show(real x, uint32_t flags)
{
    char line[40];
    char *p = line;
    uint32_t words[sizeof(real) / 4u];
    unsigned i;
    int shift;
    memcpy(words, &x, sizeof x);
    for (i = sizeof(real) / 4u; i-- > 0u;)
    {
        for (shift = 28; shift >= 0; shift -= 4)
        {
            *p++ = "0123456789abcdef"[(words[i] >> shift) & 15u];
        }
    }
    *p++ = ' ';
    p = decimal(p, flags);
    *p++ = '\n';
    *p = '\0';
    (void)semihost(0x04, line);
}

static void load(real *to, const void *from, unsigned count)
{
    memcpy(to, from, count * sizeof(real));
}

#define TICK_CONTROL (*(volatile uint32_t *)0xE000E010)
#define TICK_RELOAD (*(volatile uint32_t *)0xE000E014)
#define TICK_NOW (*(volatile uint32_t *)0xE000E018)

static void restart(void)
{
    TICK_RELOAD = 0xFFFFFFu;
    TICK_NOW = 0u;
    TICK_CONTROL = 5u;
}

static uint32_t ticks(void)
{
    return 0xFFFFFFu - TICK_NOW;
}

static state memory;
static real input[STEPS][INPUTS];
static real wanted[FIELDS];
static real result;
static volatile real sink;

/* Compiled to a call of its own, to be taken off. */
__attribute__((noinline)) static uint32_t nothing(state *s, const real in[INPUTS], real *effort)
{
    __asm__ volatile("" : : "r"(s), "r"(in) : "memory");
    *effort = in[0];
    return 0u;
}

static uint32_t timed(uint32_t (*call)(state *, const real[INPUTS], real *))
{
    uint32_t total = 0u;
    unsigned i;
    unsigned r;
    for (r = 0u; r < REPEATS; r++)
    {
        reset(&memory);
        restart();
        for (i = 0u; i < STEPS; i++)
        {
            real effort;
            (void)call(&memory, input[i], &effort);
            sink = effort;
        }
        total += ticks();
    }
    return total;
}

static void results(void)
{
    unsigned i;
    reset(&memory);
    for (i = 0u; i < STEPS; i++)
    {
        real effort;
        const uint32_t flags = step(&memory, input[i], &effort);
        show(effort, flags);
    }
    for (i = 0u; i < FIELDS; i++)
    {
        real in[INPUTS];
        real field;
        uint32_t flags;
        load(in, fields[i], INPUTS);
        flags = inverse(in, wanted[i], &field);
        show(field, flags);
    }
    reset(&memory);
    for (i = 0u; i < AHEAD; i++)
    {
        real goal;
        real field;
        uint32_t flags;
        load(&goal, ahead[i], 1u);
        flags = inverse_now(&memory, input[i], goal, &field);
        show(field, flags);
        (void)step(&memory, input[i], &result);
    }
}

/* The deepest stack of a step or an inverse: what lies below is painted, then looked through. */
__attribute__((noinline)) static uint32_t stack_of(void)
{
    volatile uint32_t *here;
    uint32_t i;
    uint32_t j;
    __asm__ volatile("mov %0, sp" : "=r"(here));
    for (i = 1u; i < PAINTED; i++)
    {
        here[-(int32_t)i] = PAINT;
    }
    reset(&memory);
    for (j = 0u; j < STEPS; j++)
    {
        (void)step(&memory, input[j], &result);
    }
    for (j = 0u; j < FIELDS; j++)
    {
        (void)inverse(input[j], wanted[j], &result);
        (void)inverse_now(&memory, input[j], wanted[j], &result);
    }
    for (i = PAINTED - 1u; (i > 0u) && (here[-(int32_t)i] == PAINT); i--)
    {
    }
    return 4u * i;
}

void start(void)
{
    const uint32_t *from = &load_of_data;
    uint32_t *to;
    unsigned i;
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
    for (i = 0u; i < STEPS; i++)
    {
        load(input[i], steps[i], INPUTS);
    }
    for (i = 0u; i < FIELDS; i++)
    {
        load(&wanted[i], &fields[i][INPUTS], 1u);
    }
    results();
    say("TICKS", timed(step));
    say("EMPTY", timed(nothing));
    say("CALLS", REPEATS * STEPS);
    say("STACK", stack_of());
    leave(0u);
}
