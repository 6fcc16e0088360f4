/* One control step without any input or output: samples in, command and frame out. The loop calls it each millisecond;
 * tests and accelerated runs call the same code from Python. */
#ifndef ERC_CORE_H
#define ERC_CORE_H

#include "erc_layout.h"

/* A compiled model (the ABI that `erclutch export` writes). */
typedef struct {
    uint32_t (*step)(void *state, const double *in, double *effort);
    uint32_t (*inverse)(const double *in, double wanted, double *field);
    void *state;
} erc_model;

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

/* 0, or what is wrong with a configuration: a text that does not change. */
const char *erc_config_error(const erc_config *config, uint64_t table_rows);

void erc_core_init(erc_core *core, const erc_config *config, const erc_row *table, const erc_model *model);

/* Checks an order and carries it out; 1 if the loop is to end. */
int erc_core_order(erc_core *core, const erc_order *order);

/* From now on fields and motor torque are zero. */
void erc_core_stop(erc_core *core);

/* One step.
 * samples: what came in since the last step, in order of arrival. tick: number of the deadline. late_ns: wake-up after
 * it. events: what input and output already saw. */
void erc_core_step(erc_core *core, const erc_sample *samples, uint32_t count, uint64_t tick, uint64_t late_ns,
                   uint32_t events, erc_command *command, erc_frame *frame);

/* Sizes for callers that only see bytes. */
uint32_t erc_core_size(void);
uint32_t erc_core_config_size(void);

/* --- parts of a step, one file each ------------------------------------------------------------------------------ */

/* erc_sensors.c; periods: since the last step, more than one after an overrun. */
uint32_t erc_sensors_take(erc_core *core, const erc_sample *samples, uint32_t count, uint64_t periods);
uint32_t erc_control(erc_core *core, uint64_t tick, double ask[3]); /* erc_control.c */
void erc_control_start(erc_core *core, uint32_t program, uint64_t tick);
uint32_t erc_interlock(const erc_config *config, double previous, double alpha, double theta_dot, const double ask[3],
                       double out[3]); /* erc_interlock.c */

#endif
