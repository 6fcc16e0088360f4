/* Packets on the wire: 64 bytes, little-endian, a sequence number, a session and a CRC32. docs/live.md has the table. */
#pragma once

#include "erc_layout.h"

#include <stddef.h>

uint32_t erc_crc32(const void *data, size_t size);
void erc_put_command(uint8_t out[ERC_PACKET_SIZE], uint32_t session, const erc_command *command);
void erc_put_sample(uint8_t out[ERC_PACKET_SIZE], uint32_t session, const erc_sample *sample);
/* 1 if the packet is whole, of this session and of this kind; else 0 and nothing is written. */
int erc_get_sample(const uint8_t *packet, size_t size, uint32_t session, erc_sample *sample);
int erc_get_command(const uint8_t *packet, size_t size, uint32_t session, erc_command *command);
