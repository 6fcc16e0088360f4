#ifndef ERC_LIBRARY_H
#define ERC_LIBRARY_H

#include "erc_core.h"

/* Loads a compiled model, checks its interface, its number of inputs and its digest, and tries one step. */
erc_model erc_model_load(const char *path, const char *digest, uint32_t device);

#endif
