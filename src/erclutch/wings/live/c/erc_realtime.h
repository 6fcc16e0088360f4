#pragma once

#include <stddef.h>
#include <stdint.h>

uint64_t erc_now(void);
void erc_sleep_until(uint64_t time_ns);
/* Asks for real-time priority and locked memory; what came of it, in words. Never fails. */
void erc_go_realtime(int priority, int cpu, char *word, size_t size);
