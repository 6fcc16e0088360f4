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

static void put_double(uint8_t *at, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put64(at, bits);
}

static uint32_t get32(const uint8_t *at) {
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static uint64_t get64(const uint8_t *at) {
    return (uint64_t)get32(at) | (uint64_t)get32(at + 4) << 32;
}

static double get_double(const uint8_t *at) {
    const uint64_t bits = get64(at);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* What samples and commands have in common: magic 0, session 4, seq 8, time 16, three numbers 24, word 48, zero 52 .. 59,
 * crc 60. */
typedef struct {
    uint64_t seq, time_ns;
    double values[3];
    uint32_t word;
} content;

static void put(uint8_t out[ERC_PACKET_SIZE], uint32_t magic, uint32_t session, content in) {
    memset(out, 0, ERC_PACKET_SIZE);
    put32(out, magic);
    put32(out + 4, session);
    put64(out + 8, in.seq);
    put64(out + 16, in.time_ns);
    for (unsigned i = 0; i < 3u; i++) {
        put_double(out + 24 + 8u * i, in.values[i]);
    }
    put32(out + 48, in.word);
    put32(out + 60, erc_crc32(out, 60));
}

static int get(const uint8_t *packet, size_t size, uint32_t magic, uint32_t session, content *out) {
    if (size != ERC_PACKET_SIZE || get32(packet) != magic || get32(packet + 4) != session ||
        get32(packet + 60) != erc_crc32(packet, 60)) {
        return 0;
    }
    out->seq = get64(packet + 8);
    out->time_ns = get64(packet + 16);
    for (unsigned i = 0; i < 3u; i++) {
        out->values[i] = get_double(packet + 24 + 8u * i);
    }
    out->word = get32(packet + 48);
    return 1;
}

void erc_put_command(uint8_t out[ERC_PACKET_SIZE], uint32_t session, const erc_command *command) {
    const erc_command *c = command;
    put(out, ERC_COMMAND_MAGIC, session,
        (content){c->seq, c->time_ns, {c->field1, c->field2, c->motor_torque}, c->flags});
}

void erc_put_sample(uint8_t out[ERC_PACKET_SIZE], uint32_t session, const erc_sample *sample) {
    const erc_sample *s = sample;
    put(out, ERC_SENSOR_MAGIC, session, (content){s->seq, s->time_ns, {s->theta, s->alpha, s->torque}, s->status});
}

int erc_get_sample(const uint8_t *packet, size_t size, uint32_t session, erc_sample *sample) {
    content in;
    if (!get(packet, size, ERC_SENSOR_MAGIC, session, &in)) {
        return 0;
    }
    *sample = (erc_sample){in.seq, in.time_ns, in.values[0], in.values[1], in.values[2], in.word};
    return 1;
}

int erc_get_command(const uint8_t *packet, size_t size, uint32_t session, erc_command *command) {
    content in;
    if (!get(packet, size, ERC_COMMAND_MAGIC, session, &in)) {
        return 0;
    }
    *command = (erc_command){in.seq, in.time_ns, in.values[0], in.values[1], in.values[2], in.word};
    return 1;
}
