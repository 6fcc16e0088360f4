/* The ring in shared memory: one writer, any number of readers that it knows nothing of. */
#pragma once

#include "erc_layout.h"

typedef struct {
    erc_ring_header *header;
    erc_frame *frames;
    uint64_t head, capacity;
} erc_ring;

erc_ring erc_ring_open(const char *path);
void erc_ring_write(erc_ring *ring, erc_frame *frame);
