#include "erc_packet.h"

#include <string.h>

/* CRC-32 of Ethernet and zlib (reflected, polynomial 0xEDB88320), four bits at a time. */
uint32_t erc_crc32(const void *data, size_t size) {
    static const uint32_t table[16] = {
        0x00000000u, 0x1db71064u, 0x3b6e20c8u, 0x26d930acu, 0x76dc4190u, 0x6b6b51f4u, 0x4db26158u, 0x5005713cu,
        0xedb88320u, 0xf00f9344u, 0xd6d6a3e8u, 0xcb61b38cu, 0x9b64c2b0u, 0x86d3d2d4u, 0xa00ae278u, 0xbdbdf21cu};
    const uint8_t *bytes = data;
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        crc = (crc >> 4) ^ table[crc & 15u];
        crc = (crc >> 4) ^ table[crc & 15u];
    }
    return ~crc;
}

static void put32(uint8_t *at, uint32_t value) {
    for (unsigned i = 0; i < 4u; i++) {
        at[i] = (uint8_t)(value >> (8u * i));
    }
}

static void put64(uint8_t *at, uint64_t value) {
    put32(at, (uint32_t)value);
    put32(at + 4, (uint32_t)(value >> 32));
}

static uint32_t get32(const uint8_t *at) {
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static uint64_t get64(const uint8_t *at) {
    return (uint64_t)get32(at) | (uint64_t)get32(at + 4) << 32;
}

/* What samples and commands have in common: magic 0, session 4, then five words of 8 bytes (seq 8, time 16, three numbers
 * 24), status or flags at 48, device 52, zero 56, crc 60. They stand in the same order in erc_sample and erc_command. */
typedef struct {
    uint64_t words[5];
    uint32_t last, device;
} content;

_Static_assert(offsetof(erc_sample, status) == offsetof(content, last) && sizeof(erc_sample) == sizeof(content), "sample");
_Static_assert(offsetof(erc_command, flags) == offsetof(content, last) && sizeof(erc_command) == sizeof(content), "command");

static void put(uint8_t out[ERC_PACKET_SIZE], uint32_t magic, uint32_t session, const void *from) {
    content in;
    memcpy(&in, from, sizeof in);
    memset(out, 0, ERC_PACKET_SIZE);
    put32(out, magic);
    put32(out + 4, session);
    for (unsigned i = 0; i < 5u; i++) {
        put64(out + 8u + 8u * i, in.words[i]);
    }
    put32(out + 48, in.last);
    put32(out + 52, in.device);
    put32(out + 60, erc_crc32(out, 60));
}

static int get(const uint8_t *packet, size_t size, uint32_t magic, uint32_t session, void *to) {
    if (size != ERC_PACKET_SIZE || get32(packet) != magic || get32(packet + 4) != session ||
        get32(packet + 60) != erc_crc32(packet, 60)) {
        return 0;
    }
    content out = {{0}, get32(packet + 48), get32(packet + 52)};
    for (unsigned i = 0; i < 5u; i++) {
        out.words[i] = get64(packet + 8u + 8u * i);
    }
    memcpy(to, &out, sizeof out);
    return 1;
}

void erc_put_command(uint8_t out[ERC_PACKET_SIZE], uint32_t session, const erc_command *command) {
    put(out, ERC_COMMAND_MAGIC, session, command);
}

void erc_put_sample(uint8_t out[ERC_PACKET_SIZE], uint32_t session, const erc_sample *sample) {
    put(out, ERC_SENSOR_MAGIC, session, sample);
}

int erc_get_sample(const uint8_t *packet, size_t size, uint32_t session, erc_sample *sample) {
    return get(packet, size, ERC_SENSOR_MAGIC, session, sample);
}

int erc_get_command(const uint8_t *packet, size_t size, uint32_t session, erc_command *command) {
    return get(packet, size, ERC_COMMAND_MAGIC, session, command);
}
