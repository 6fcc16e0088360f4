/* What the operator wants, as fields: tracking by equation (23) or by computed torque, torque by the inverse model, a
 * spring and a damper, a wall, or predefined fields. */
#include "erc_control.h"

#include "erc_inverse.h"
#include "erc_torque.h"

#include <math.h>

#define TWO_PI 6.283185307179586
#define OUT_OF_REACH 16u /* the model's flag */
#define PULLED 10u       /* periods */
#define NEAR_REST 3.0       /* rad/s: dry friction is elastic, and turns only some way after the motion has */
#define RESTS_FOR 64u    /* periods after which the usual field of a rest is known */
#define PULLS_BACK 3.0   /* times its dry friction: a spring that pulls harder ends the rest */
#define MORE_AT_REST 0.1 /* of that field, and ... */
#define LEAST_MORE 0.005 /* of the field limit: more is asked for at once */

/* A trajectory's value, its rate and the rate's rate now. */
typedef struct {
    double value, rate, second_rate, motor;
    double second; /* of a table row: the second field */
} wanted_t;

static wanted_t of_table(const erc_core *core, const erc_program *program, uint64_t k) {
    if ((program->flags & ERC_BY_SAMPLE) != 0u) {
        k = core->sensor_seq - 1u;
    }
    uint64_t row = k;
    if (k >= program->rows) {
        row = (program->flags & ERC_REPEAT) != 0u ? k % program->rows : program->rows - 1u;
    }
    const erc_row *at = &core->table[program->first + row];
    return (wanted_t){at->first, at->second, 0.0, at->motor_torque, at->second};
}

static wanted_t of_shape(const erc_core *core, const erc_program *program, uint64_t k) {
    /* Whole periods are taken away in turns, so that the phase is as fine after a day as after a second. */
    const double omega = TWO_PI * program->frequency;
    const double turns = fmod((double)k * core->dt * program->frequency, 1.0);
    wanted_t wanted = {program->offset, 0.0, 0.0, program->motor_torque, 0.0};
    switch (program->shape) {
    case ERC_SINE:
        wanted.value += program->amplitude * sin(TWO_PI * turns);
        wanted.rate = program->amplitude * TWO_PI * program->frequency * cos(TWO_PI * turns);
        wanted.second_rate = -omega * omega * (wanted.value - program->offset);
        break;
    case ERC_SQUARE:
        wanted.value += turns < 0.5 ? program->amplitude : -program->amplitude;
        break;
    default:
        wanted.value += program->amplitude;
        break;
    }
    return wanted;
}

/* E of equation (23): k_p (alpha_r - alpha) + k_d (alpha_r' - alpha'). */
static double tracking(const erc_core *core, const wanted_t *wanted) {
    const erc_config *config = &core->config;
    return config->k_p * (wanted->value - core->alpha.measured) + config->k_d * (wanted->rate - core->alpha.speed);
}

/* The rate of the reference less that of the output. The output's is late by its filter: without as late a reference an
 * output that follows exactly would look too slow whenever it speeds up. */
static double rate_off(erc_core *core, double rate) {
    erc_followed *f = &core->followed;
    if (!f->begun) {
        *f = (erc_followed){0.0, rate, 0.0, rate, 1};
    } else {
        f->at += 0.5 * core->dt * (rate + f->rate);
        f->rate = rate;
        const double predicted = f->position + core->dt * f->speed;
        f->position = predicted + core->config.filter_g * (f->at - predicted);
        f->speed += core->config.filter_h * (f->at - predicted) / core->dt;
    }
    return f->speed - core->alpha.speed;
}

/* Computed torque: what the output's inertia and friction take on the trajectory, and what brings the output back to it
 * as a mass on a critically damped spring. The integral stands still while the field can do no more. */
static double computed_torque(erc_core *core, const wanted_t *wanted, uint32_t *events) {
    const erc_config *config = &core->config;
    const double stiff = TWO_PI * config->track_bandwidth;
    const double off = wanted->value - core->alpha.measured;
    const double back = stiff * (2.0 * rate_off(core, wanted->rate) + stiff * (off + core->tracking_integral));
    const double torque =
        config->output_inertia * (wanted->second_rate + back) + config->output_friction * tanh(wanted->rate);
    const double field = erc_torque_field(core, torque, 0.0, events);
    if ((*events & ERC_UNREACHABLE) == 0u || off * core->tracking_integral < 0.0) {
        core->tracking_integral += config->track_integral * core->dt * off;
    }
    return field;
}

/* Whether an output rests that nothing but the loop and dry friction acts on: nobody tells it to go elsewhere, its friction
 * is elastic, and the spring hardly pulls more than that friction withstands. */
static bool rests(erc_core *core, double reference, double rate) {
    const erc_config *config = &core->config;
    erc_rest *rest = &core->rest;
    const double way = core->alpha.measured - rest->place;
    const bool told = rate != 0.0 || reference != rest->reference;
    const bool slow = fabs(core->alpha.speed) <= NEAR_REST;
    const bool near = config->stiffness > 0.0 && config->stiffness * fabs(way) <= PULLS_BACK * config->load_friction;
    rest->reference = reference;
    if (config->load_inertia > 0.0 && !told && slow && near) {
        return true;
    }
    rest->place = core->alpha.measured;
    rest->field = 0.0;
    rest->periods = 0u;
    return false;
}

/* What rests asks for no more field than its rest does. A spring and a damper of an encoder that is late would swing it up
 * by themselves: torque and motion disagree too little there to tell of the encoder before the field is high. */
static double as_at_rest(erc_core *core, double field) {
    erc_rest *rest = &core->rest;
    const bool known = rest->periods >= RESTS_FOR;
    const double most = (1.0 + MORE_AT_REST) * rest->field + LEAST_MORE * core->config.field_limit;
    const double asked = known && fabs(field) > most ? (field < 0.0 ? -most : most) : field;
    rest->periods += known ? 0u : 1u;
    rest->field += (known ? core->stages.slow : 1.0 / (double)rest->periods) * (fabs(asked) - rest->field);
    return asked;
}

/* A spring and a damper between the output and its reference. The spring's rate goes along, so that the stages' lead makes
 * good what the command's lag takes off the damping. */
static double impedance(erc_core *core, const wanted_t *wanted, uint32_t *events) {
    const double stiff = core->config.stiffness, rate = rate_off(core, wanted->rate);
    const double torque = stiff * (wanted->value - core->alpha.measured) + core->config.damping * rate;
    const double before = core->stages.integral;
    const double field = erc_torque_field(core, torque, stiff * rate, events);
    if (!isfinite(field) || !rests(core, wanted->value, wanted->rate)) {
        return field;
    }
    const double asked = as_at_rest(core, field);
    if (fabs(asked) < fabs(field) && fabs(core->stages.integral) > fabs(before)) {
        core->stages.integral = before; /* it does not wind up */
    }
    return asked;
}

/* Where the brake's moving side is: its angle less that of the other side. */
static double turned(const erc_core *core) {
    return core->theta.measured - core->alpha.measured;
}

/* Whether the hand goes into the wall. It goes back when it leaves the play, by which shaft and fluid spring back from a
 * push; or when a torque sensor sees it pull for longer than they swing: a brake at rest would hold it like the push. */
static int goes_in(erc_core *core, double deep) {
    const int pulls = core->config.observer == ERC_BY_SENSOR && core->meter.doubted == 0u &&
                      core->torque < -core->config.torque_scale;
    core->pulled = pulls ? core->pulled + 1u : 0u;
    if (deep > core->deepest) {
        core->deepest = deep;
        core->inward = 1u;
    } else if (deep < core->deepest - core->config.wall_play || core->pulled == PULLED) {
        core->deepest = deep + core->config.wall_play;
        core->inward = 0u;
    }
    return core->inward != 0u;
}

/* A wall that a brake renders: spring and damper beyond it, on the way in. On the way back the brake lets go: asked for no
 * torque, the inverse of some models would give a small field. A brake that drags is no torque out of reach. */
static double wall(erc_core *core, const wanted_t *wanted, uint32_t *events) {
    const double deep = turned(core) - wanted->value, speed = core->theta.speed - core->alpha.speed;
    const double torque = core->config.stiffness * deep + core->config.damping * speed;
    const int into = goes_in(core, deep) && deep > 0.0 && torque > 0.0;
    core->reference = into ? torque : 0.0;
    const double rate = into ? core->config.stiffness * speed : 0.0;
    uint32_t drags = 0u;
    const double field = erc_torque_field(core, core->reference, rate, into ? events : &drags);
    return into ? field : 0.0;
}

/* Field for a wanted torque: the model's inverse, corrected by what the model says the device now gives. */
static double corrected_inverse(erc_core *core, double wanted, uint32_t *events) {
    const erc_config *config = &core->config;
    const double coaxial[5] = {0.0, 0.0, core->theta.speed, core->alpha.speed, 0.0};
    const double single[3] = {0.0, core->theta.speed - core->alpha.speed, 0.0};
    double forward = 0.0;
    const uint32_t flags = erc_inverse(core, config->device == ERC_SINGLE ? single : coaxial, wanted, &forward);
    if ((flags & OUT_OF_REACH) != 0u) {
        *events |= ERC_UNREACHABLE;
    }
    const double error = isfinite(core->estimate) ? wanted - core->estimate : 0.0;
    /* The field's sign is the torque's only while the motor turns forward. */
    const double way = core->theta.speed < 0.0 ? -1.0 : 1.0;
    const double before = core->integral;
    core->integral += way * config->torque_i * error * core->dt;
    const double field = forward + way * config->torque_p * error + core->integral;
    if (!(fabs(field) <= config->field_limit)) { /* saturated, or not finite: the integral does not wind up */
        core->integral = before;
    }
    return field;
}

static double torque_field(erc_core *core, const wanted_t *wanted, uint32_t *events) {
    return core->config.observer == ERC_NO_STAGES ? corrected_inverse(core, wanted->value, events)
                                                  : erc_torque_field(core, wanted->value, wanted->rate, events);
}

/* A predefined sequence: beyond `soft` whole half-waves are mirrored, so that the table comes back. A sequence changes
 * sides, or steps, between half-waves: only there may its mirror begin or end. */
static double mirrored(erc_core *core, const erc_program *program, double wave) {
    if (wave * core->last_wave <= 0.0 || fabs(wave - core->last_wave) > 0.1) {
        const double drive = core->theta.speed < 0.0 ? -wave : wave;
        const double at = core->alpha.measured;
        const int outward = (at > program->soft && drive > 0.0) || (at < -program->soft && drive < 0.0);
        core->mirrored = program->soft > 0.0 && outward ? -1.0 : 1.0;
    }
    core->last_wave = wave;
    return core->mirrored;
}

void erc_control_start(erc_core *core, uint32_t program, uint64_t tick) {
    core->program = program;
    core->program_tick = tick;
    core->integral = 0.0;
    core->tracking_integral = 0.0;
    core->followed.begun = 0;
    core->rest = (erc_rest){0.0, 0.0, 0.0, 0u};
    erc_torque_start(core);
    core->mirrored = 1.0;
    core->last_wave = 0.0;
    core->deepest = -(double)INFINITY;
    core->inward = core->pulled = 0u;
    core->motor = (double)NAN; /* the program's own */
    const double here = core->config.list[program].mode == ERC_WALL ? turned(core) : core->alpha.measured;
    core->base = (core->config.list[program].flags & ERC_RELATIVE) != 0u ? here : 0.0;
}

/* The equation's split: E1 = E, E2 = 0 for E >= 0; E1 = 0, E2 = |E| for E < 0. A single device has only the first. */
static void split(const erc_core *core, double field, double ask[3]) {
    ask[0] = field >= 0.0 ? field : 0.0;
    ask[1] = field >= 0.0 || core->config.device == ERC_SINGLE ? 0.0 : -field;
    if (isnan(field)) {
        ask[0] = field; /* the interlock says so */
    }
}

/* The law's field is clipped to the supply's range, as the paper's is: that is no event. */
static double saturated(const erc_core *core, double field) {
    const double limit = core->config.field_limit;
    return field > limit ? limit : (field < -limit ? -limit : field);
}

uint32_t erc_control(erc_core *core, uint64_t tick, double ask[3]) {
    uint32_t events = 0u;
    const erc_program *program = &core->config.list[core->program];
    const uint64_t k = tick - core->program_tick;
    wanted_t wanted = program->shape == ERC_TABLE ? of_table(core, program, k) : of_shape(core, program, k);
    ask[0] = 0.0;
    ask[1] = 0.0;
    ask[2] = isnan(core->motor) ? wanted.motor : core->motor;
    core->reference = (double)NAN;
    switch (program->mode) {
    case ERC_TRACK:
        wanted.value += core->base;
        core->reference = wanted.value;
        split(core,
              saturated(core, core->config.track_bandwidth > 0.0 ? computed_torque(core, &wanted, &events)
                                                                 : tracking(core, &wanted)),
              ask);
        break;
    case ERC_IMPEDANCE:
        wanted.value += core->base;
        core->reference = wanted.value;
        split(core, saturated(core, impedance(core, &wanted, &events)), ask);
        break;
    case ERC_WALL:
        wanted.value += core->base;
        split(core, wall(core, &wanted, &events), ask);
        break;
    case ERC_TORQUE:
        core->reference = wanted.value;
        split(core, saturated(core, torque_field(core, &wanted, &events)), ask);
        break;
    case ERC_FIELDS:
        if (program->shape == ERC_TABLE) {
            const int turned = mirrored(core, program, wanted.value - wanted.second) < 0.0;
            ask[0] = turned ? wanted.second : wanted.value;
            ask[1] = turned ? wanted.value : wanted.second;
        } else {
            split(core, mirrored(core, program, wanted.value) * wanted.value, ask);
        }
        break;
    default:
        break;
    }
    return events;
}
