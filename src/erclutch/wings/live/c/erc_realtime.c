#define _GNU_SOURCE
#include "erc_realtime.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

#ifdef __linux__
#include <sched.h>
#include <sys/prctl.h>
#endif

#define SECOND 1000000000u

/* The clock of Python's time.monotonic_ns. The wall clock may jump; this one does not. */
uint64_t erc_now(void) {
#ifdef __APPLE__
    return clock_gettime_nsec_np(CLOCK_UPTIME_RAW);
#else
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * SECOND + (uint64_t)now.tv_nsec;
#endif
}

/* Interrupted by a signal it sleeps on: the caller looks at its flags at the deadline, at most one period later. */
void erc_sleep_until(uint64_t time_ns) {
#ifdef __linux__
    const struct timespec until = {(time_t)(time_ns / SECOND), (long)(time_ns % SECOND)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, 0) == EINTR) {
    }
#else
    for (uint64_t now = erc_now(); now < time_ns; now = erc_now()) {
        const struct timespec left = {(time_t)((time_ns - now) / SECOND), (long)((time_ns - now) % SECOND)};
        (void)nanosleep(&left, 0);
    }
#endif
}

/* Touch the stack that the loop will use, so that no page is missing later. */
static void touch_stack(void) {
    volatile char room[256u * 1024u];
    for (size_t i = 0; i < sizeof room; i += 4096u) {
        room[i] = 0;
    }
}

void erc_go_realtime(int priority, int cpu, char *word, size_t size) {
    char scheduling[80] = "normal priority", memory[80] = "memory locked", place[32] = "";
#ifdef __linux__
    if (priority > 0) {
        const struct sched_param parameter = {.sched_priority = priority};
        if (sched_setscheduler(0, SCHED_FIFO, &parameter) == 0) {
            (void)snprintf(scheduling, sizeof scheduling, "SCHED_FIFO priority %d", priority);
        } else {
            (void)snprintf(scheduling, sizeof scheduling, "normal priority (SCHED_FIFO: %s)", strerror(errno));
        }
    }
    if (cpu >= 0) {
        cpu_set_t set;
        CPU_ZERO(&set);
        CPU_SET((size_t)cpu, &set);
        (void)snprintf(place, sizeof place, sched_setaffinity(0, sizeof set, &set) == 0 ? ", cpu %d" : ", not cpu %d",
                       cpu);
    }
    (void)prctl(PR_SET_TIMERSLACK, 1ul, 0ul, 0ul, 0ul); /* without real-time priority timers are 50 us lazy */
#else
    (void)priority;
    (void)cpu;
#endif
    if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
        (void)snprintf(memory, sizeof memory, "memory not locked (%s)", strerror(errno));
    }
    touch_stack();
    (void)snprintf(word, size, "%s, %s%s", scheduling, memory, place);
}
