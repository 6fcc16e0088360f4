/* Layouts that cross a border: frames, the ring, samples, commands, orders and the configuration. This file is their only
 * source: live/layout.py reads it, so its form is kept. Each line of a struct has one type, a comment says the unit in
 * brackets, and the comment of an event is the text that people read. Little-endian, aligned as C aligns. */
#pragma once

#include <stdint.h>

/* --- frame ------------------------------------------------------------------------------------------------------- */

/* Names and units are those of the coaxial pair. A single device has the position across its fluid in theta, the slip in
 * theta_dot, its field in field1 and its effort in torque; signals/channels.py names all of them, the ring's header too. */
typedef struct {
    uint64_t seq;                /* number of the step, from 0 */
    uint64_t time_ns;            /* [ns] monotonic clock at the wake-up */
    double theta, alpha;         /* [rad] motor and output, unwrapped */
    double theta_dot, alpha_dot; /* [rad/s] by the causal filter */
    double field1, field2;       /* applied: after the interlock */
    double motor_torque;         /* [N*m] command */
    double torque;               /* [N*m] measured; NaN where there is none */
    double estimate;             /* [N*m] by the model; NaN without a model */
    double reference;            /* of the trajectory, rad or N m; NaN where there is none */
    uint32_t flags;              /* the model's */
    uint32_t events;             /* of this step */
    int32_t lateness_ns;         /* [ns] wake-up after its deadline */
    uint32_t step_ns;            /* [ns] from the wake-up to the command sent */
} erc_frame;
_Static_assert(sizeof(erc_frame) == 112, "frame");

/* Bits of `events`. The ring's header counts each over the whole session. */
enum {
    ERC_SAMPLE_LOST = 1u << 0,         /* no new sample from the rig in this step */
    ERC_SAMPLE_INVALID = 1u << 1,      /* a sensor value was not finite */
    ERC_GLITCH = 1u << 2,              /* a sensor jumped further than can be: the sample was not used */
    ERC_WRAP = 1u << 3,                /* an encoder went over its range and was unwrapped */
    ERC_BAD_PACKET = 1u << 4,          /* a packet of wrong size, checksum, version or session was dropped */
    ERC_STALE_PACKET = 1u << 5,        /* a duplicated or reordered packet was dropped */
    ERC_CLOCK_JUMP = 1u << 6,          /* the rig's time stamps jumped */
    ERC_OVERRUN = 1u << 7,             /* the step before came late: one deadline or more was missed */
    ERC_HOLD = 1u << 8,                /* the last command was held for want of a sample */
    ERC_DEGRADE = 1u << 9,             /* the command was reduced for want of samples */
    ERC_TRIP = 1u << 10,               /* fields went to zero and stay there until a reset */
    ERC_BOTH_FIELDS = 1u << 11,        /* both fields were asked for; the smaller gave way */
    ERC_BEYOND_LIMIT = 1u << 12,       /* a field or torque beyond its limit was asked for and clipped */
    ERC_RATE_LIMITED = 1u << 13,       /* the field was held to the supply's rate */
    ERC_COMMAND_NOT_FINITE = 1u << 14, /* control asked for what is not finite: it counts as zero */
    ERC_RIG_WATCHDOG = 1u << 15, /* the rig itself set the fields to zero: no command came in time */
    ERC_RIG_FAULT = 1u << 16,    /* the rig reported a fault */
    ERC_ORDER = 1u << 17,        /* an operator's order was carried out */
    ERC_ORDER_REFUSED = 1u << 18, /* an operator's order was out of range, unknown, or not for this state */
    ERC_UNREACHABLE = 1u << 19,  /* the wanted torque is out of the model's reach */
    ERC_SEND_FAILED = 1u << 20,  /* the command could not be sent to the rig */
    ERC_STOPPING = 1u << 21,     /* the loop is ending: fields to zero */
    ERC_GUARD = 1u << 22,        /* near an end stop: fields that drive further out were refused */
    ERC_THETA_DOUBTED = 1u << 23,  /* the first angle cannot be; another event says why */
    ERC_ALPHA_DOUBTED = 1u << 24,  /* the second angle cannot be; another event says why */
    ERC_TORQUE_DOUBTED = 1u << 25, /* the measured torque cannot be; another event says why */
    ERC_OUT_OF_RANGE = 1u << 26,   /* a sensor read more than device or sensor can give: not used */
    ERC_STUCK = 1u << 27,          /* a sensor read the same while it had to change: not used */
    ERC_DISAGREES = 1u << 28       /* the measured torque is too far from the model's, or the motion from the torque */
};

/* --- ring -------------------------------------------------------------------------------------------------------- */

#define ERC_RING_MAGIC 0x31474E4952435245u /* "ERCRING1" */
#define ERC_RING_VERSION 3u
#define ERC_HEADER_SIZE 4096u
#define ERC_CHANNELS 10u

/* Ready: a reset cleared the trip; fields and motor stay at zero until an operator runs a program. */
enum { ERC_STARTING = 0, ERC_RUNNING = 1, ERC_TRIPPED = 2, ERC_STOPPED = 3, ERC_READY = 4 };

/* A number of the frame: where it stands and how a device calls it, as UTF-8 that ends with zero. */
typedef struct {
    char name[24], slot[16], role[16], unit[16], label[56];
} erc_channel;

typedef struct {
    uint64_t magic;
    uint32_t version, frame_size;
    uint64_t capacity, period_ns, start_ns, start_unix_ns;
    char unused0[16];
    char rig[64], origin[16], model[64], digest[64], note[256];
    double field_limit, motor_limit;
    uint32_t channels, unused1; /* how many there are */
    erc_channel channel[ERC_CHANNELS];
    char unused2[216];
    uint64_t head; /* offset 2048: from here on the loop writes */
    /* trip_reason: bits of the events that tripped. missed: deadlines that were skipped. */
    uint32_t state, pid, mode, program, trip_reason, missed;
    char unused3[32];
    uint64_t counts[32];
    uint64_t sensor_seq;
    char unused4[56];
    char realtime[128];
    char unused5[1536];
} erc_ring_header;
_Static_assert(sizeof(erc_ring_header) == ERC_HEADER_SIZE, "ring header");

/* --- packets ----------------------------------------------------------------------------------------------------- */

#define ERC_SENSOR_MAGIC 0x31535245u  /* "ERS1" */
#define ERC_COMMAND_MAGIC 0x31435245u /* "ERC1" */
#define ERC_PACKET_SIZE 64u

enum { ERC_STATUS_WATCHDOG = 1, ERC_STATUS_FAULT = 2 };

/* One reading of the rig's sensors. */
typedef struct {
    uint64_t seq;     /* counts the rig's samples; one a period */
    uint64_t time_ns; /* the rig's own clock */
    double theta, alpha, torque; /* a single device: position, its other side's (0: it stands still), effort */
    uint32_t status, device;     /* device: ERC_COAXIAL or ERC_SINGLE, in packets */
} erc_sample;

/* What the rig is to do until the next command. */
typedef struct {
    uint64_t seq;
    uint64_t time_ns;
    double field1, field2, motor_torque; /* a single device: field, 0, drive */
    uint32_t flags, device;              /* flags 1: this is the last command, the loop is ending */
} erc_command;

/* --- orders of an operator --------------------------------------------------------------------------------------- */

#define ERC_ORDER_MAGIC 0x4F435245u /* "ERCO" */
enum { ERC_ORDER_STOP = 1, ERC_ORDER_ZERO = 2, ERC_ORDER_RESET = 3, ERC_ORDER_PROGRAM = 4, ERC_ORDER_MOTOR = 5 };

typedef struct {
    uint32_t magic, kind;
    double value;
    uint32_t unused, crc; /* CRC32 of the bytes before it */
} erc_order;
_Static_assert(sizeof(erc_order) == 24, "order");

/* --- configuration ----------------------------------------------------------------------------------------------- */

#define ERC_CONFIG_MAGIC 0x47435245u /* "ERCG" */
#define ERC_CONFIG_VERSION 4u
#define ERC_PROGRAMS 32u
/* Periods from zero field to the trip: room for what the system, the wire and the last good sample were late by. */
#define ERC_ZERO_BEFORE_TRIP 7u
/* Periods in which a sensor that reads the same to the bit is not stuck yet; and how many periods are kept of what was
 * asked and learned, so that what came of such a sensor can be forgotten. */
#define ERC_STILL 5u
#define ERC_EARLIER 8u

/* Impedance: a spring and a damper between the output of a pair and the reference. Wall: a brake resists beyond it. */
enum { ERC_REST = 0, ERC_TRACK = 1, ERC_TORQUE = 2, ERC_FIELDS = 3, ERC_IMPEDANCE = 4, ERC_WALL = 5 };
enum { ERC_CONSTANT = 0, ERC_SINE = 1, ERC_SQUARE = 2, ERC_TABLE = 3 };
enum { ERC_COAXIAL = 0, ERC_SINGLE = 1 };
/* Torque control: gains on the estimate; or stages that know the torque by the model alone, a sensor, or the drive's
 * motion. */
enum { ERC_NO_STAGES = 0, ERC_BY_MODEL = 1, ERC_BY_SENSOR = 2, ERC_BY_MOTION = 3 };

enum {
    ERC_REPEAT = 1u,    /* a table starts again at its end; else its last row holds */
    ERC_BY_SAMPLE = 2u, /* row k of a table goes with sample k + 1 of the rig (replay), whenever that comes */
    ERC_RELATIVE = 4u   /* the reference counts from where the output is when the program starts */
};

/* A trajectory or a predefined sequence, and what is controlled by it. */
typedef struct {
    uint32_t mode, shape, flags, unused;
    double amplitude, frequency, offset;
    double motor_torque; /* N m; a table has its own */
    double soft;         /* rad; ERC_FIELDS: half-waves that drive the output further out are mirrored; 0: none */
    uint64_t first, rows; /* of the table file */
} erc_program;
_Static_assert(sizeof(erc_program) == 72, "program");

/* How a setting may be: above zero, zero or above, or of either sign. None is larger than ERC_MOST, and none that has to
 * be above zero is below ERC_LEAST: with larger and smaller ones the arithmetic overflows. */
enum { ERC_ABOVE_ZERO = 0, ERC_FROM_ZERO = 1, ERC_SIGNED = 2 };
#define ERC_MOST 1e12
#define ERC_LEAST 1e-9

/* A row of the table file: reference and its rate, or the two fields; then the motor torque. */
typedef struct {
    double first, second, motor_torque;
} erc_row;

#define ERC_SETTING(kind, name) double name;
typedef struct {
    uint32_t magic, version, size, device;
    uint64_t period_ns;
    double filter_g, filter_h;       /* gains of the position-speed filter (signals/speed.py) */
#include "erc_settings.h"
    uint64_t late_trip_ns;           /* a wake-up later than this trips */
    uint32_t hold_samples, trip_samples;
    uint32_t programs, program;      /* how many, and which at the start */
    erc_program list[ERC_PROGRAMS];
    uint32_t observer, crc;
} erc_config;
#undef ERC_SETTING
_Static_assert(sizeof(erc_config) == 16 + 8 + 45 * 8 + 8 + 16 + 72 * ERC_PROGRAMS + 8, "config");
