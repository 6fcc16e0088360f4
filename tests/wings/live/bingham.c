/* A small model with the interface of an exported one, for tests of the loop: two Bingham clutches; with SINGLE a brake. */
#include <math.h>
#include <stddef.h>
#include <stdint.h>

#define YIELD 2.0
#define VISCOSITY 2.0e-3

typedef struct {
    double effort;
} state_t;

const char *erc_model_digest(void) { return "0000000000000000000000000000000000000000000000000000000000000001"; }
const char *erc_model_name(void) { return "bingham-by-hand"; }
uint32_t erc_model_abi(void) { return 1u; }
#ifdef SINGLE
uint32_t erc_model_inputs(void) { return 2u; }
#define E2 0.0
#define W1 in[1]
#define W2 0.0
#else
uint32_t erc_model_inputs(void) { return 4u; }
#define E2 in[1]
#define W1 (in[2] - in[3])
#define W2 (-in[2] - in[3])
#endif
uint32_t erc_model_state_size(void) { return (uint32_t)sizeof(state_t); }
void erc_model_reset(void *state) { ((state_t *)state)->effort = 0.0; }

static double sign(double x) { return x / (0.1 + fabs(x)); }

uint32_t erc_model_step(void *state, const double *in, double *effort) {
    state_t *own = state;
    const double w1 = W1, w2 = W2;
    uint32_t flags = in[0] > 0.0 && E2 > 0.0 ? 4u : 0u;
    const double value = YIELD * (in[0] * in[0] * sign(w1) + E2 * E2 * sign(w2)) + VISCOSITY * (w1 + w2);
    if (isfinite(value)) {
        own->effort = value;
    } else {
        flags |= 2u;
    }
    if (fabs(w1) > 100.0 || fabs(w2) > 100.0) {
        flags |= 1u;
    }
    *effort = own->effort;
    return flags;
}

uint32_t erc_model_inverse(const double *in, double wanted, double *field) {
    const double w1 = W1, w2 = W2;
    const double left = wanted - VISCOSITY * (w1 + w2);
    const double yield = left * (left >= 0.0 ? sign(w1) : -sign(w2)) / YIELD;
    const double size = sqrt(fabs(yield));
    *field = copysign(size > 0.5 ? 0.5 : size, left);
    return size > 0.5 || yield < 0.0 ? 16u : 0u;
}

uint32_t erc_model_inverse_now(const void *memory, const double *in, double wanted, double *field) {
    (void)memory;
    return erc_model_inverse(in, wanted, field);
}

uint32_t erc_model_steady(const double *in, double *effort) {
    state_t state = {0.0};
    return erc_model_step(&state, in, effort);
}

void erc_model_run(void *state, size_t rows, const double *in, double *effort, uint32_t *flags) {
    for (size_t i = 0; i < rows; i++) {
        flags[i] = erc_model_step(state, &in[erc_model_inputs() * i], &effort[i]);
    }
}
