/* A rig as the loop sees it: over UDP, or a shared library of the user's that talks to hardware.
 *
 * The library's symbols (all of them; see docs/live.md):
 *   uint32_t erc_rig_abi(void);                                     1
 *   void    *erc_rig_open(const char *options, char *error, uint32_t error_size);   NULL: failed, reason in error
 *   int32_t  erc_rig_read(void *rig, erc_sample *sample);           1: a new sample, 0: none, -1: a fault
 *   int32_t  erc_rig_write(void *rig, const erc_command *command);  0: done
 *   void     erc_rig_close(void *rig);
 * None of them may block. A loop that is killed cannot close it: its hardware needs a watchdog of its own.
 */
#pragma once

#include "erc_layout.h"

#define ERC_RIG_ABI 1u
#define ERC_MOST_SAMPLES 64u /* that are taken in one step */

typedef struct {
    int socket; /* -1: a library */
    uint32_t session, device; /* that packets carry */
    void *self;
    int32_t (*read)(void *rig, erc_sample *sample);
    int32_t (*write)(void *rig, const erc_command *command);
    void (*close)(void *rig);
} erc_rig;

/* Both end the process with a message if it cannot be done. */
erc_rig erc_rig_udp(const char *host, const char *port, const char *local_port, const char *session,
                    uint32_t device);
erc_rig erc_rig_library(const char *path, const char *options);

/* What came in since the last call, at most ERC_MOST_SAMPLES. */
uint32_t erc_rig_receive(erc_rig *rig, erc_sample *samples, uint32_t *events);
/* 0, or ERC_SEND_FAILED. */
uint32_t erc_rig_send(erc_rig *rig, const erc_command *command);
void erc_rig_end(erc_rig *rig);
