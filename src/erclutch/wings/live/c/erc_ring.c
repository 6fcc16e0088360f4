#include "erc_ring.h"

#include "erc_start.h"

erc_ring erc_ring_open(const char *path) {
    size_t size;
    erc_ring_header *header = erc_file_map(path, 1, &size);
    if (size < ERC_HEADER_SIZE || header->magic != ERC_RING_MAGIC || header->version != ERC_RING_VERSION ||
        header->frame_size != sizeof(erc_frame) || header->capacity < 2u ||
        header->capacity != (size - ERC_HEADER_SIZE) / sizeof(erc_frame)) {
        erc_fail("%s is no ring of version %u", path, ERC_RING_VERSION);
    }
    erc_frame *frames = (erc_frame *)(void *)((char *)header + ERC_HEADER_SIZE);
    return (erc_ring){header, frames, header->head, header->capacity};
}

void erc_ring_write(erc_ring *ring, erc_frame *frame) {
    frame->seq = ring->head;
    for (uint32_t bit = 0; bit < 32u; bit++) {
        ring->header->counts[bit] += (frame->events >> bit) & 1u;
    }
    ring->frames[ring->head % ring->capacity] = *frame;
    ring->head++;
    __atomic_store_n(&ring->header->head, ring->head, __ATOMIC_RELEASE);
}
