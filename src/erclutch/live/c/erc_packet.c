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

/* magic 0, session 4, seq 8, time 16, three numbers 24, word 48, zero 52 .. 59, crc 60 */
static void put(uint8_t out[ERC_PACKET_SIZE], uint32_t magic, uint32_t session, uint64_t seq, uint64_t time_ns,
                const double values[3], uint32_t word) {
    memset(out, 0, ERC_PACKET_SIZE);
    put32(out, magic);
    put32(out + 4, session);
    put64(out + 8, seq);
    put64(out + 16, time_ns);
    for (unsigned i = 0; i < 3u; i++) {
        put_double(out + 24 + 8u * i, values[i]);
    }
    put32(out + 48, word);
    put32(out + 60, erc_crc32(out, 60));
}

static int whole(const uint8_t *packet, size_t size, uint32_t magic, uint32_t session) {
    return size == ERC_PACKET_SIZE && get32(packet) == magic && get32(packet + 4) == session &&
           get32(packet + 60) == erc_crc32(packet, 60);
}

void erc_put_command(uint8_t out[ERC_PACKET_SIZE], uint32_t session, const erc_command *command) {
    const double values[3] = {command->field1, command->field2, command->motor_torque};
    put(out, ERC_COMMAND_MAGIC, session, command->seq, command->time_ns, values, command->flags);
}

void erc_put_sample(uint8_t out[ERC_PACKET_SIZE], uint32_t session, const erc_sample *sample) {
    const double values[3] = {sample->theta, sample->alpha, sample->torque};
    put(out, ERC_SENSOR_MAGIC, session, sample->seq, sample->time_ns, values, sample->status);
}

int erc_get_sample(const uint8_t *packet, size_t size, uint32_t session, erc_sample *sample) {
    if (!whole(packet, size, ERC_SENSOR_MAGIC, session)) {
        return 0;
    }
    sample->seq = get64(packet + 8);
    sample->time_ns = get64(packet + 16);
    sample->theta = get_double(packet + 24);
    sample->alpha = get_double(packet + 32);
    sample->torque = get_double(packet + 40);
    sample->status = get32(packet + 48);
    return 1;
}

int erc_get_command(const uint8_t *packet, size_t size, uint32_t session, erc_command *command) {
    if (!whole(packet, size, ERC_COMMAND_MAGIC, session)) {
        return 0;
    }
    command->seq = get64(packet + 8);
    command->time_ns = get64(packet + 16);
    command->field1 = get_double(packet + 24);
    command->field2 = get_double(packet + 32);
    command->motor_torque = get_double(packet + 40);
    command->flags = get32(packet + 48);
    return 1;
}
