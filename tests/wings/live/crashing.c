/* A model that crashes after half a second, for tests of what the loop does then. */
#include <stdint.h>

const char *erc_model_digest(void) { return "0000000000000000000000000000000000000000000000000000000000000001"; }
const char *erc_model_name(void) { return "crashing"; }
uint32_t erc_model_abi(void) { return 1u; }
#ifdef SINGLE
uint32_t erc_model_inputs(void) { return 2u; }
#else
uint32_t erc_model_inputs(void) { return 4u; }
#endif
uint32_t erc_model_state_size(void) { return 16u; }
void erc_model_reset(void *state) { *(uint64_t *)state = 0u; }

uint32_t erc_model_step(void *state, const double *in, double *effort) {
    uint64_t *steps = state;
    *effort = in[0];
    if (++*steps > 500u) {
        *(volatile int *)8 = 1;
    }
    return 0u;
}

uint32_t erc_model_inverse(const double *in, double wanted, double *field) {
    (void)in;
    *field = wanted; /* so that torque and motion control run until then */
    return 0u;
}

uint32_t erc_model_steady(const double *in, double *effort) {
    *effort = in[0];
    return 0u;
}
