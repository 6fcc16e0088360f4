#define _GNU_SOURCE
#include "erc_realtime.h"

#include <errno.h>
#include <sched.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <time.h>

#define SECOND 1000000000u

uint64_t erc_now(void) {
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now); /* the wall clock may jump; this one does not */
    return (uint64_t)now.tv_sec * SECOND + (uint64_t)now.tv_nsec;
}

void erc_sleep_until(uint64_t time_ns) {
    const struct timespec until = {(time_t)(time_ns / SECOND), (long)(time_ns % SECOND)};
    /* Interrupted by a signal: the caller looks at its flags at the deadline, at most one period later. */
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, 0) == EINTR) {
    }
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
    if (priority > 0) {
        const struct sched_param parameter = {.sched_priority = priority};
        if (sched_setscheduler(0, SCHED_FIFO, &parameter) == 0) {
            (void)snprintf(scheduling, sizeof scheduling, "SCHED_FIFO priority %d", priority);
        } else {
            (void)snprintf(scheduling, sizeof scheduling, "normal priority (SCHED_FIFO: %s)", strerror(errno));
        }
    }
    if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
        (void)snprintf(memory, sizeof memory, "memory not locked (%s)", strerror(errno));
    }
    if (cpu >= 0) {
        cpu_set_t set;
        CPU_ZERO(&set);
        CPU_SET((size_t)cpu, &set);
        (void)snprintf(place, sizeof place, sched_setaffinity(0, sizeof set, &set) == 0 ? ", cpu %d" : ", not cpu %d",
                       cpu);
    }
    (void)prctl(PR_SET_TIMERSLACK, 1ul, 0ul, 0ul, 0ul); /* without real-time priority timers are 50 us lazy */
    touch_stack();
    (void)snprintf(word, size, "%s, %s%s", scheduling, memory, place);
}
