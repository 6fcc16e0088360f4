/* What a control step keeps until the next one. */
#pragma once

#include "erc_layout.h"
#include "erc_model.h"

/* An angle encoder: unwrapping, rejection of impossible jumps, and a position-speed filter. */
typedef struct {
    double wrap, glitch, offset; /* offset: whole wraps so far */
    double measured;             /* last good reading, unwrapped */
    double position, speed;      /* the filter's */
    uint64_t since;              /* periods since the last good reading */
    uint32_t taken;              /* good readings since the start, up to the warm-up */
} erc_encoder;

typedef struct {
    erc_config config;
    const erc_row *table;
    erc_model model;
    double dt;
    erc_encoder theta, alpha;
    double torque;
    uint64_t sensor_seq, sensor_time, resync; /* resync: any sequence number is taken */
    uint32_t missing;                         /* periods in a row without a good sample */
    uint32_t lost_by;                         /* event that made the latest one bad */
    uint32_t state, trip_reason, stopping, rig_seen, torque_seen;
    uint64_t step, program_tick;
    uint32_t program;
    double base, motor, integral, estimate, reference;
    double mirrored, last_wave;         /* of a predefined sequence near the end of the stroke */
    double asked1, asked2, asked_motor; /* by control, at the last good sample */
    double field;                       /* applied, signed */
    uint32_t pending;                   /* events of orders since the last step */
} erc_core;
