#define _GNU_SOURCE
#include "erc_rig.h"

#include "erc_packet.h"
#include "erc_start.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

static struct sockaddr_in address(const char *host, const char *port) {
    struct sockaddr_in out;
    char *end;
    const unsigned long number = strtoul(port, &end, 10);
    memset(&out, 0, sizeof out);
    out.sin_family = AF_INET;
    if (*end != '\0' || number > 65535ul || inet_pton(AF_INET, host, &out.sin_addr) != 1) {
        erc_fail("not an IPv4 address and port: %s %s", host, port);
    }
    out.sin_port = htons((uint16_t)number);
    return out;
}

erc_rig erc_rig_udp(const char *host, const char *port, const char *local_port, const char *session,
                    uint32_t device) {
    const struct sockaddr_in there = address(host, port);
    /* On loopback nothing from outside is to reach us. */
    const int loopback = (ntohl(there.sin_addr.s_addr) >> 24) == 127u;
    const struct sockaddr_in here = address(loopback ? "127.0.0.1" : "0.0.0.0", local_port);
    erc_rig rig = {-1, (uint32_t)strtoul(session, 0, 0), device, 0, 0, 0, 0};
    rig.socket = socket(AF_INET, SOCK_DGRAM, 0);
    /* Connected: the kernel drops what comes from anybody else. */
    if (rig.socket < 0 || fcntl(rig.socket, F_SETFL, O_NONBLOCK) != 0 || bind(rig.socket, (const struct sockaddr *)&here, sizeof here) != 0 ||
        connect(rig.socket, (const struct sockaddr *)&there, sizeof there) != 0) {
        erc_fail("no socket to %s %s from port %s: %s", host, port, local_port, strerror(errno));
    }
    return rig;
}

erc_rig erc_rig_library(const char *path, const char *options) {
    erc_rig rig = {-1, 0u, 0u, 0, 0, 0, 0};
    uint32_t (*abi)(void);
    void *(*open_rig)(const char *, char *, uint32_t);
    char error[256] = "";
    void *library = erc_library("the rig's library", path);
    erc_symbol(library, path, "erc_rig_abi", &abi);
    erc_symbol(library, path, "erc_rig_open", &open_rig);
    erc_symbol(library, path, "erc_rig_read", &rig.read);
    erc_symbol(library, path, "erc_rig_write", &rig.write);
    erc_symbol(library, path, "erc_rig_close", &rig.close);
    if (abi() != ERC_RIG_ABI) {
        erc_fail("the rig's library %s has interface %u, not %u", path, abi(), ERC_RIG_ABI);
    }
    rig.self = open_rig(options, error, sizeof error);
    error[sizeof error - 1u] = '\0';
    if (rig.self == 0) {
        erc_fail("the rig's library %s: %s", path, error);
    }
    return rig;
}

static uint32_t receive_udp(erc_rig *rig, erc_sample *samples, uint32_t *events) {
    uint8_t packet[ERC_PACKET_SIZE + 1u]; /* one more, to see that a packet is too long */
    uint32_t count = 0u;
    for (uint32_t i = 0; i < ERC_MOST_SAMPLES; i++) {
        const ssize_t size = recv(rig->socket, packet, sizeof packet, 0);
        if (size < 0) {
            if (errno == EINTR || errno == ECONNREFUSED) {
                continue; /* refused: an earlier command found no rig, and we are told now */
            }
            break;
        }
        if (erc_get_sample(packet, (size_t)size, rig->session, &samples[count]) &&
            samples[count].device == rig->device) {
            count++;
        } else {
            *events |= ERC_BAD_PACKET;
        }
    }
    return count;
}

uint32_t erc_rig_receive(erc_rig *rig, erc_sample *samples, uint32_t *events) {
    uint32_t count = 0u;
    if (rig->socket >= 0) {
        return receive_udp(rig, samples, events);
    }
    while (count < ERC_MOST_SAMPLES) {
        const int32_t found = rig->read(rig->self, &samples[count]);
        if (found < 0) {
            *events |= ERC_RIG_FAULT;
        }
        if (found <= 0) {
            break;
        }
        count++;
    }
    return count;
}

uint32_t erc_rig_send(erc_rig *rig, const erc_command *command) {
    uint8_t packet[ERC_PACKET_SIZE];
    if (rig->socket < 0) {
        return rig->write(rig->self, command) == 0 ? 0u : (uint32_t)ERC_SEND_FAILED;
    }
    erc_put_command(packet, rig->session, command);
    for (unsigned attempt = 0; attempt < 3u; attempt++) {
        if (send(rig->socket, packet, sizeof packet, 0) == (ssize_t)sizeof packet) {
            return 0u;
        }
        /* The first send after a refusal only reports it: the packet itself has not gone yet. */
        if (errno != ECONNREFUSED && errno != EINTR) {
            break;
        }
    }
    return ERC_SEND_FAILED;
}

void erc_rig_end(erc_rig *rig) {
    if (rig->socket >= 0) {
        (void)close(rig->socket);
    } else {
        rig->close(rig->self);
    }
}
