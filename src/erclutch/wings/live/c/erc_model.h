#pragma once

#include <stdint.h>

/* A compiled model (the ABI that `erclutch export` writes). */
typedef struct {
    uint32_t (*step)(void *state, const double *in, double *effort);
    uint32_t (*inverse)(const double *in, double wanted, double *field);
    void (*reset)(void *state);
    void *state;
    uint32_t (*steady)(const double *in, double *effort); /* 0: not known */
} erc_model;

/* Loads a compiled model, checks its interface, its number of inputs and its digest, and tries one step. */
erc_model erc_model_load(const char *path, const char *digest, uint32_t device);
