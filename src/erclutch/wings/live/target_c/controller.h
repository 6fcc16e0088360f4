/* What the controller has to know of the rig. NAME_CONTROL_DEFAULTS has numbers to begin with: set the supply's rates,
   the lead and the sensor to yours. N m and rad/s stand for the units of this model: @UNITS@. */
typedef struct {
@SETTINGS@
    uint32_t observer;               /* NAME_BY_MODEL: no torque is measured; NAME_BY_SENSOR; NAME_BY_MOTION */
} erc_config;

#define NAME_CONTROL_DEFAULTS { \
    @DEFAULTS@ \
}

/* One sample. */
typedef struct {
    double wanted, rate;    /* torque that is wanted, and its rate of change */
    double theta_dot;       /* speed of the drive; of a single device the slip */
    double alpha_dot, alpha; /* speed and position of the output; 0 of a single device */
    double torque;          /* measured; not a number where there is none */
    double motor_torque;    /* that the drive is asked for; for NAME_BY_MOTION */
} erc_input;

/* What to command, and what the model says of it. */
typedef struct {
    double field1, field2; /* at most one of them is above zero */
    double estimate;       /* torque by the model with its memory */
} erc_output;

@STAGES@
typedef struct {
    double measured, speed;
} erc_side;

/* Everything that the controller remembers; one for each device. */
typedef struct {
    erc_config config;
    erc_stages stages;
    NAME_state model;
    erc_side theta, alpha;
    erc_meter meter;
    erc_momentum momentum;
    double torque, estimate, asked_motor, driven, field, dt, asked[2];
    bool tripped;
    uint32_t since; /* periods since the last good sample; 0: none yet */
    uint32_t astray; /* samples since then whose speed cannot be */
    uint64_t step;
} erc_core;

/* Before the first sample. 0: a setting is not finite or out of its range, and all fields stay zero. */
uint32_t erc_control_reset(erc_core *controller, const erc_config *config);

/* One sample: the fields for a torque, within limits and rates, never both. Returns the flags of the step, and of the
   events above. A sample that is not finite, or whose slip is ten times that of the log, or with a speed that has jumped
   (theta_glitch, alpha_glitch: by so much in a period), takes the field to zero at the supply's rate; speeds that cannot be
   for more than @HOLD@ samples keep it there until a reset. With NAME_BY_SENSOR a torque that cannot be is not learned
   from: the field does not grow, then falls, and is zero after some periods, for good after a few more. */
uint32_t erc_control_step(erc_core *controller, const erc_input *input, erc_output *output);
