/* A rig behind a library, for tests: a motor at 40 rad/s; its option says after how many samples it faults. */
#include "erc_rig.h"

#include <stdio.h>
#include <stdlib.h>

static erc_sample now;
static uint64_t fault_after;

uint32_t erc_rig_abi(void) { return ERC_RIG_ABI; }

void *erc_rig_open(const char *options, char *error, uint32_t error_size) {
    fault_after = strtoull(options, 0, 10);
    if (fault_after == 0u) {
        (void)snprintf(error, error_size, "no such device: %s", options);
        return 0;
    }
    return &now;
}

int32_t erc_rig_read(void *rig, erc_sample *sample) {
    static int turn;
    erc_sample *own = rig;
    turn = !turn;
    if (!turn) {
        return 0; /* one sample a step */
    }
    own->seq++;
    own->time_ns += 1000000u;
    own->theta += 0.04;
    own->torque = 0.1;
    *sample = *own;
    return own->seq > fault_after ? -1 : 1;
}

int32_t erc_rig_write(void *rig, const erc_command *command) {
    (void)rig;
    return command->field1 >= 0.0 ? 0 : -1;
}

void erc_rig_close(void *rig) { (void)rig; }
