/* A rig behind UDP in C: a motor with friction that two clutches hang on. Put your sensors and outputs in its place.
 *
 *     C=$(python -c "import erclutch.wings.live.c_build as b; print(b.SOURCES)")
 *     cc -std=c11 -O2 -I"$C" peer.c "$C/erc_packet.c" -lm -o peer
 *     ./peer 5005 42 &
 *     erclutch live --rig udp --address 127.0.0.1:5005 --session 42 --program tracking-slow
 *
 * It answers each command with its next sample; without commands it goes on by its own clock, and its watchdog sets the
 * fields to zero after 15 ms.
 */
#define _GNU_SOURCE
#include "erc_packet.h"

#include <arpa/inet.h>
#include <math.h>
#include <poll.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>

#define PERIOD_NS 1000000u
#define WATCHDOG_NS 15000000u
#define DEVICE ERC_COAXIAL /* ERC_SINGLE: one brake, clutch or damper; then field1, theta and torque are all that it has */

static uint64_t now_ns(void) {
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

/* --- the device: here a sum of two Bingham clutches on an inertia ------------------------------------------------ */

static double theta, theta_dot, alpha, alpha_dot, torque;

static void pass_a_period(const erc_command *command) {
    const double dt = 1e-3;
    const double drive1 = tanh((theta_dot - alpha_dot) / 2.0), drive2 = tanh((-theta_dot - alpha_dot) / 2.0);
    torque = 2.0 * (command->field1 * command->field1 * drive1 + command->field2 * command->field2 * drive2) -
             4e-4 * alpha_dot;
    theta_dot += dt * (command->motor_torque - 2e-3 * theta_dot) / 3e-4;
    alpha_dot += dt * (torque - 1e-3 * tanh(alpha_dot)) / 2e-4;
    theta += dt * theta_dot;
    alpha += dt * alpha_dot;
}

/* --- the packets --------------------------------------------------------------------------------------------------- */

int main(int count, char **words) {
    if (count != 3) {
        (void)fprintf(stderr, "usage: peer PORT SESSION\n");
        return 2;
    }
    const uint32_t session = (uint32_t)strtoul(words[2], 0, 0);
    struct sockaddr_in here, loop;
    socklen_t size = sizeof loop;
    memset(&here, 0, sizeof here);
    here.sin_family = AF_INET;
    here.sin_port = htons((uint16_t)atoi(words[1]));
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK); /* INADDR_ANY to be heard from outside */
    const int port = socket(AF_INET, SOCK_DGRAM, 0);
    if (port < 0 || bind(port, (struct sockaddr *)&here, sizeof here) != 0) {
        perror("peer");
        return 2;
    }
    const struct sched_param ahead = {.sched_priority = 70};
    (void)sched_setscheduler(0, SCHED_FIFO, &ahead); /* a rig does not wait for a browser; without permission it may */
    erc_command command = {0}, received;
    uint64_t heard = 0, due = UINT64_MAX, last = 0, seq = 0;
    int watchdog = 1;
    for (;;) {
        uint8_t packet[ERC_PACKET_SIZE + 1u];
        struct pollfd ready = {port, POLLIN, 0};
        const uint64_t now = now_ns();
        const struct timespec wait = {0, due == UINT64_MAX ? 100000000 : (due > now ? (long)(due - now) : 0)};
        int taken = 0;
        if (ppoll(&ready, 1, &wait, 0) > 0) {
            const ssize_t bytes = recvfrom(port, packet, sizeof packet, 0, (struct sockaddr *)&loop, &size);
            /* While the watchdog holds, a loop that was started anew may count from one again. */
            if (bytes > 0 && erc_get_command(packet, (size_t)bytes, session, &received) &&
                received.device == DEVICE && (watchdog || received.seq > last)) {
                command = received;
                last = received.seq;
                heard = now_ns();
                watchdog = 0;
                taken = 1;
                if ((command.flags & 1u) != 0u) {
                    command.field1 = command.field2 = 0.0; /* the loop says goodbye */
                }
            }
        }
        if (seq == 0u && !taken) {
            continue; /* nobody has spoken yet */
        }
        if (!taken && now_ns() < due) {
            continue;
        }
        if (now_ns() - heard > WATCHDOG_NS) {
            command.field1 = command.field2 = command.motor_torque = 0.0;
            watchdog = 1;
        }
        pass_a_period(&command);
        const uint32_t status = watchdog ? ERC_STATUS_WATCHDOG : 0u;
        const erc_sample sample = {++seq, now_ns(), theta, alpha, torque, status, DEVICE};
        erc_put_sample(packet, session, &sample);
        (void)sendto(port, packet, ERC_PACKET_SIZE, 0, (struct sockaddr *)&loop, size);
        due = now_ns() + (taken ? PERIOD_NS * 3u / 2u : PERIOD_NS);
    }
}
