#define _GNU_SOURCE
#include "erc_library.h"

#include "erc_fail.h"

#include <dlfcn.h>
#include <string.h>

#define MODEL_ABI 1u
#define LARGEST_STATE 65536u

static void symbol(void *library, const char *path, const char *name, void *function) {
    void *found = dlsym(library, name);
    if (found == 0) {
        erc_fail("the model %s has no %s", path, name);
    }
    memcpy(function, &found, sizeof found); /* POSIX lets an object pointer be a function's */
}

erc_model erc_model_load(const char *path, const char *digest, uint32_t device) {
    static _Alignas(16) unsigned char memory[LARGEST_STATE];
    erc_model model = {0, 0, memory};
    const char *(*own_digest)(void);
    uint32_t (*abi)(void), (*inputs)(void), (*state_size)(void);
    void (*reset)(void *);
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (library == 0) {
        erc_fail("the model cannot be loaded: %s", dlerror());
    }
    symbol(library, path, "erc_model_abi", &abi);
    symbol(library, path, "erc_model_digest", &own_digest);
    symbol(library, path, "erc_model_inputs", &inputs);
    symbol(library, path, "erc_model_state_size", &state_size);
    symbol(library, path, "erc_model_reset", &reset);
    symbol(library, path, "erc_model_step", &model.step);
    symbol(library, path, "erc_model_inverse", &model.inverse);
    const uint32_t wanted = device == ERC_SINGLE ? 2u : 4u;
    if (abi() != MODEL_ABI || inputs() != wanted || state_size() > LARGEST_STATE) {
        erc_fail("the model %s has interface %u, %u inputs and %u bytes of state; the loop takes %u, %u and %u", path,
                 abi(), inputs(), state_size(), MODEL_ABI, wanted, LARGEST_STATE);
    }
    if (digest[0] != '\0' && strcmp(digest, own_digest()) != 0) {
        erc_fail("the model %s has digest %s, not %s", path, own_digest(), digest);
    }
    /* Once now, so that its pages are there when time counts. */
    const double still[4] = {0.0, 0.0, 0.0, 0.0};
    double effort = 0.0;
    reset(memory);
    (void)model.step(memory, still, &effort);
    (void)model.inverse(still, 0.0, &effort);
    reset(memory);
    return model;
}
