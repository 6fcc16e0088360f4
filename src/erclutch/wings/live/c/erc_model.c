#include "erc_model.h"

#include "erc_layout.h"
#include "erc_start.h"

#include <string.h>

#define MODEL_ABI 1u
#define LARGEST_STATE 65536u

erc_model erc_model_load(const char *path, const char *digest, uint32_t device) {
    static _Alignas(16) unsigned char memory[LARGEST_STATE];
    erc_model model = {0, 0, 0, memory, 0};
    const char *(*own_digest)(void);
    uint32_t (*abi)(void), (*inputs)(void), (*state_size)(void);
    void *library = erc_library("the model", path);
    erc_symbol(library, path, "erc_model_abi", &abi);
    erc_symbol(library, path, "erc_model_digest", &own_digest);
    erc_symbol(library, path, "erc_model_inputs", &inputs);
    erc_symbol(library, path, "erc_model_state_size", &state_size);
    erc_symbol(library, path, "erc_model_reset", &model.reset);
    erc_symbol(library, path, "erc_model_step", &model.step);
    erc_symbol(library, path, "erc_model_inverse", &model.inverse);
    erc_symbol(library, path, "erc_model_steady", &model.steady);
    const uint32_t wanted = device == ERC_SINGLE ? 2u : 4u;
    const int measures = inputs() == wanted + 1u; /* its last input is the measured torque */
    if (abi() != MODEL_ABI || (inputs() != wanted && !measures) || state_size() > LARGEST_STATE) {
        erc_fail("the model %s has interface %u, %u inputs and %u bytes of state; the loop takes %u, %u and %u", path,
                 abi(), inputs(), state_size(), MODEL_ABI, wanted, LARGEST_STATE);
    }
    if (digest[0] != '\0' && strcmp(digest, own_digest()) != 0) {
        erc_fail("the model %s has digest %s, not %s", path, own_digest(), digest);
    }
    /* Once now, so that its pages are there when time counts. */
    const double still[5] = {0.0, 0.0, 0.0, 0.0, 0.0};
    double effort = 0.0;
    model.reset(memory);
    (void)model.step(memory, still, &effort);
    (void)model.inverse(still, 0.0, &effort);
    (void)model.steady(still, &effort);
    model.reset(memory);
    return model;
}
