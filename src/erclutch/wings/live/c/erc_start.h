/* What the loop does only while it starts. Each function ends the process where it cannot do its work. */
#pragma once

#include <stddef.h>

/* The one way in which the loop refuses to start: a line on standard error, exit code 2. */
_Noreturn void erc_fail(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Maps a whole file, with all its pages there; shared: for writing too. */
void *erc_file_map(const char *path, int shared, size_t *size);

/* A shared library (what: its name for people), and a function of it: `function` is the address of the pointer to it. */
void *erc_library(const char *what, const char *path);
void erc_symbol(void *library, const char *path, const char *name, void *function);
