#define _GNU_SOURCE
#include "erc_ring.h"

#include "erc_fail.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

erc_ring erc_ring_open(const char *path) {
    struct stat about;
    const int file = open(path, O_RDWR | O_CLOEXEC);
    if (file < 0 || fstat(file, &about) != 0 || about.st_size < (off_t)ERC_HEADER_SIZE) {
        erc_fail("%s is no ring: %s", path, file < 0 ? strerror(errno) : "too short");
    }
    const size_t size = (size_t)about.st_size;
    void *map = mmap(0, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file, 0);
    (void)close(file);
    if (map == MAP_FAILED) {
        erc_fail("%s cannot be mapped: %s", path, strerror(errno));
    }
    erc_ring ring = {map, (erc_frame *)(void *)((char *)map + ERC_HEADER_SIZE), 0u, 0u};
    ring.capacity = ring.header->capacity;
    if (memcmp(ring.header->magic, ERC_RING_MAGIC, sizeof ring.header->magic) != 0 ||
        ring.header->version != ERC_RING_VERSION || ring.header->frame_size != sizeof(erc_frame) ||
        ring.capacity < 2u || ring.capacity != (size - ERC_HEADER_SIZE) / sizeof(erc_frame)) {
        erc_fail("%s is no ring of version %u", path, ERC_RING_VERSION);
    }
    ring.head = ring.header->head;
    return ring;
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
