/* What a control step keeps until the next one. */
#pragma once

#include "erc_layout.h"
#include "erc_model.h"

#include <stdbool.h>

/* An angle encoder: unwrapping, rejection of impossible jumps, and a position-speed filter. */
typedef struct {
    double wrap, glitch, offset; /* offset: whole wraps so far */
    double measured;             /* last good reading, unwrapped */
    double position, speed;      /* the filter's */
    double fastest, farthest;    /* speed and angle that it cannot reach; 0: none */
    double end;                  /* angle beyond which an end stop may turn it; 0: none */
    double reading, count;       /* the last one as it came; the least by which two have differed */
    double moving;               /* speed when the reading last changed */
    double came;                 /* speed with which it came to its end stop, while it is beyond; else its speed */
    double behind;               /* periods that count besides, after samples that were missing */
    uint64_t since;              /* periods since the last good reading */
    uint32_t still;              /* periods since the reading changed */
    uint32_t taken;              /* good readings since the start, up to the warm-up */
} erc_encoder;

/* What a device gives of its model's torque, the drag on its drive, and how far off both may be. */
typedef struct {
    double gain, drag, spread[3];
} erc_share;

/* What the stages of torque control keep. Torques in N m. */
typedef struct {
    erc_share learned[2];           /* of each clutch */
    double rest, integral;          /* what the device gives beyond them; integral action */
    double late, modelled;          /* the model's torque as late as the measured one is */
    double reaction;                /* on the drive, with the model's torque filtered as it is */
    double speed, slow_speed;       /* of the drive one step ago, and filtered */
    double found, gave, slope;      /* the last field that was found, its torque, and the torque per field; 0: none */
    double turned;                  /* what slips, and a slope that turns, add to that torque in a period */
    double lacking;                 /* torque that the field is short of */
    uint32_t beyond;                /* periods left in which that is believed */
    double side, way;               /* +1: clutch 1, -1: clutch 2; +1: the motor turns or last turned forward */
    bool locked;                    /* both sides run at one speed */
    uint32_t settled, ease;         /* periods on this clutch, and left in which the field changes slowly */
    double fast, late_share;        /* shares by which the filters of observer and delay move in a period */
    double per_period;              /* of the error that the integral takes in a period */
    double usual, products, squares; /* what the sensor adds as a rule: a torque, and its share of what is asked */
    double slow;                    /* share by which these move in a period */
    double earlier[ERC_EARLIER][2];           /* rest and integral of the last periods, by the step */
    uint64_t step;                  /* the last one */
} erc_stages;

/* What is known of the torque sensor by its last readings together. */
typedef struct {
    double offset;              /* [N m] by which it reads beyond the model's torque as a rule */
    double usual;               /* [N^2 m^2] the square of its usual distance from both */
    double off[ERC_EARLIER];    /* [N^2 m^2] squares of the last distances from both */
    double turned[ERC_EARLIER]; /* [N^2 m^2] the same from the turned torque */
    double apart[ERC_EARLIER];  /* [N m] by which the last ones were beyond the model's torque */
    double varies;              /* [N^2 m^2] the square of what that usually changes by in a reading */
    double moved;               /* [N m] by how much the model's torque has moved of late; a rotor still rings by some of that */
    double field;               /* a reading ago */
    uint32_t place, readings;   /* of the next square; how many readings */
    uint64_t step;              /* of the last one */
    uint32_t in_time;           /* readings in a row that each came a period after the last, up to ERC_EARLIER */
    uint32_t rested;            /* readings in a row of a load at rest under one field */
    uint32_t slipped;           /* and with the slip under a field of one sign that tells the torque */
    bool stepped;               /* all at once the meter reads another torque than the model's, and goes on so */
} erc_turn;

/* What is known of the torque sensor. Torques in N m. */
typedef struct {
    double reading, believed;    /* the last reading as it came, and the last that can be */
    double count;                /* the least by which two readings in a row have differed */
    double expected;             /* the model's torque, as late as the measured one */
    double low, high;            /* its range since the reading changed */
    double earlier[ERC_EARLIER]; /* and what it was in the last periods, round and round */
    double low_from[ERC_EARLIER], high_from[ERC_EARLIER]; /* of the round before, from a place to its end */
    double lowest, highest;      /* of this round */
    double moved;                /* by how much it has moved in the last periods */
    uint32_t place;              /* of the next of these */
    uint32_t still, since;       /* periods since the reading changed, and since the last believed one */
    uint32_t reason;             /* why the latest one was not believed */
    uint32_t readings, longest;  /* how many, and the most periods that a good sensor ever read the same */
    uint32_t little;             /* good readings in a row that say little */
    uint32_t doubted;            /* how long it has been wrong, in periods; a good reading takes one off */
    uint32_t alone;              /* the same of what shows without a comparison with the model's torque */
    uint32_t guessed;            /* periods left in which what the model expects is a guess outside its log */
    bool seen, wrong;            /* ever read; the latest cannot be */
    bool good, unlearn;          /* the latest may be learned from; what was learned of late is in doubt */
    erc_turn turn;
} erc_meter;

/* What is known of the momentum of the output, or of the drive of a single device: where nothing but dry friction acts on
 * that side beside the measured torque and the motor's, each tells what the other has to be. Torques in N m. */
typedef struct {
    double g, h;         /* gains of the filter through which the speed of that side came */
    double torque;       /* a period ago */
    double changed;      /* by how much it changed then; and how much of such changes is in two periods in a row: it rings */
    double rings;
    double late[2];      /* through that filter, in this period and the last one: as late as the speed */
    double passed;       /* the torque less friction, through a filter */
    double speed;        /* of that side, through the same */
    double driven;       /* by the motor, through the same */
    double size, rests;  /* of the torque, and the share of the time at rest, through the same */
    double held, scatter; /* what dry friction takes of the torque of a load at rest, and by how much that varies there */
    double field;        /* a period ago */
    uint32_t doubted;    /* how long both have disagreed, in periods; agreement takes one off */
    uint32_t before;     /* the same a step ago: samples that come together may bring several */
    uint32_t stands;     /* periods at rest */
    uint32_t calm;       /* periods in which nothing changed that acts on it either */
    uint32_t jumped;     /* periods in a row in which what friction takes is another than before, all at once */
    uint32_t little;     /* agreements that say little */
    uint32_t unsure;     /* periods left, after samples that were missing, in which nothing follows */
    uint32_t apart;      /* periods since both were compared, where missing samples were why they were not */
    uint32_t unseen;     /* the same when a doubt began */
    uint32_t nearly;     /* periods left in which both have nearly disagreed of late */
    bool begun;
} erc_momentum;

/* The rate of a reference through the filter of the output's speed, so that both are late by the same. */
typedef struct {
    double at, rate, position, speed; /* at: the rate's integral, which the filter follows */
    int begun;
} erc_followed;

/* An output that rests under impedance. */
typedef struct {
    double reference, place; /* [rad] where it was told to be a period ago; where it was when the rest began */
    double field;            /* size of the field, as a rule */
    uint32_t periods;        /* so long, up to those after which that field is known */
} erc_rest;

typedef struct {
    erc_config config;
    const erc_row *table;
    erc_model model;
    double dt;
    erc_encoder theta, alpha;
    double torque;
    erc_meter meter;
    erc_momentum momentum;
    uint64_t sensor_seq, sensor_time, resync; /* resync: any sequence number is taken */
    uint64_t heard;                           /* the step of the latest sample, good or not */
    uint32_t missing;                         /* periods in a row without a good sample */
    uint32_t lost_by;                         /* events that made the latest one bad */
    uint32_t state, trip_reason, stopping, rig_seen;
    uint64_t step, program_tick;
    uint32_t program;
    erc_stages stages;
    erc_followed followed;
    erc_rest rest;
    double tracking_integral, deepest; /* rad; of a wall: the upper end of its play */
    uint32_t inward, pulled;           /* the hand goes into the wall; periods that it pulled */
    double base, motor, integral, estimate, reference;
    double mirrored, last_wave;         /* of a predefined sequence near the end of the stroke */
    double asked1, asked2, asked_motor; /* by control, at the last good sample */
    double earlier[ERC_EARLIER][2];               /* the same of the last periods, by the step */
    double field, driven;               /* applied: signed; by the motor */
    uint32_t pending;                   /* events of orders since the last step */
} erc_core;
