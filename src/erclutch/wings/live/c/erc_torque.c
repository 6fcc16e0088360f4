/* Torque control in stages: the torque by a sensor or by motion, what the device gives beyond its model, slips whose sign
 * is known, the model's inverse, integral action, the hand-over between the clutches. */
#include "erc_torque.h"

#include "erc_inverse.h"
#include "erc_plausible.h"

#include <math.h>

#define TWO_PI 6.283185307179586
#define OUT_OF_REACH 16u  /* the model's flag */
#define EASE 20u          /* periods after a start or a gap in which the field changes slowly */
#define SETTLED 50u       /* periods on one clutch after which filters have forgotten the other */
#define HAND_OVER 0.02    /* of the field limit: a smaller field does not wake the other clutch */
#define LEAST_GAIN 0.5    /* of the model's torque; the most is its inverse */
#define FIRST_GAIN 0.001  /* how far off gain and drag may be at first: squared, in their scales */
#define FIRST_DRAG 1.0
#define MOST_SPREAD 1000.0
#define THICKEST 3.0      /* of the drag that the log has */
#define ENOUGH 0.01       /* of torque_scale: an inverse so near is found */
#define AT_END 0.9        /* of the field limit: the model may end a little earlier */
#define LOOK_ANEW 100u    /* periods at an end of the field */
#define SECANTS 8u        /* at most, before the inverse begins anew */
#define ASIDE 1e-3        /* of the field limit, for a slope */
#define SPEED_SCALE 100.0 /* rad/s */
#define MOST_TORQUE 1e9   /* N m: nothing asks for more and no filter takes more: each forgets a sample that cannot be */
#define LEAST_KEPT 0.5    /* of what a clutch's gain is learned from, in a period */
#define MOST_OFF 100.0    /* of torque_scale, and TIMES the model's torque: no more is learned from or integrated */
#define TIMES 4.0
#define MORE 0.1          /* of what is asked, and of torque_scale: what a sensor adds at once beyond what it adds as a rule */
#define RULE 1.0          /* s in which that rule is learned */
#define MOST_SPEED 100.0  /* of SPEED_SCALE: beyond, nothing is learned */

static double bounded(double x, double low, double high) {
    return x < low ? low : (x > high ? high : x);
}

/* The same on both sides of zero: a number within asks once. */
static double no_larger(double x, double most) {
    return fabs(x) <= most ? x : bounded(x, -most, most);
}

/* How far a torque may be off where the model gives so much. */
static double likely(const erc_core *core, double modelled) {
    const double off = MOST_OFF * core->config.torque_scale + TIMES * fabs(modelled); /* above zero, or NaN */
    return off > MOST_TORQUE ? MOST_TORQUE : off;
}

/* Share by which a first-order filter moves in a period. */
static double share(double rate, double dt) {
    return 1.0 - exp(-rate * dt);
}

/* Drag of both clutches on the drive, as the log has it. */
static double known_drag(const erc_core *core) {
    const double first = core->config.drive_drag_1, second = core->config.drive_drag_2;
    return core->config.device == ERC_SINGLE ? first : 0.5 * (first + second);
}

/* What the clutches pull the output with while neither has a field: they pull it in turn ways, and the drive in one. So
 * it is half of what one drags more on the drive than the other. */
static double without_field(const erc_core *core) {
    const bool pair = core->config.observer == ERC_BY_MOTION && core->config.device != ERC_SINGLE;
    const double apart = core->config.drive_drag_2 - core->config.drive_drag_1;
    return pair ? 0.5 * apart * core->stages.slow_speed : 0.0;
}

void erc_torque_start(erc_core *core) {
    const erc_share first = {1.0, 0.0, {FIRST_GAIN, 0.0, FIRST_DRAG}};
    static const erc_stages none;
    erc_stages s = none;
    s.side = s.way = 1.0;
    s.learned[0] = s.learned[1] = first;
    s.learned[0].drag = s.learned[1].drag = known_drag(core);
    s.fast = share(TWO_PI * core->config.observer_bandwidth, core->dt);
    s.late_share = core->config.torque_lag > 0.0 ? share(1.0 / core->config.torque_lag, core->dt) : 1.0;
    s.slow = share(1.0 / RULE, core->dt);
    s.per_period = share(core->config.integral_rate, core->dt);
    core->stages = s;
}

/* After a start or a gap the field begins where it is. */
static void begin_anew(erc_core *core) {
    erc_stages *s = &core->stages;
    if (core->step - s->step != 1u) {
        s->ease = EASE;
        s->settled = 0u;
        s->speed = s->slow_speed = core->theta.speed;
        s->late = s->modelled = 0.0;
        s->reaction = s->learned[0].drag * s->speed;
        if (core->config.observer == ERC_BY_SENSOR && isfinite(core->estimate)) {
            s->modelled = core->estimate; /* the sensor goes on where it was */
        }
    }
    s->step = core->step;
}

/* The drive's torque, less what speeds the drive up and its dry friction, is what the clutch under field passes on and
 * what drags. The model's torque goes through the same filter, so no speed is differentiated. */
static double by_motion(erc_core *core) {
    const erc_config *config = &core->config;
    erc_stages *s = &core->stages;
    const double rate = TWO_PI * config->observer_bandwidth, slow = s->fast;
    const double omega = core->theta.speed;
    const double motor = no_larger(core->asked_motor, config->motor_limit);
    const double passed = motor - config->drive_friction * tanh(omega);
    s->reaction += slow * (passed - s->reaction) - rate * config->drive_inertia * (omega - s->speed);
    s->speed = omega;
    s->late += s->late_share * (s->side * (core->estimate - without_field(core)) - s->late);
    s->modelled += slow * (s->late - s->modelled);
    s->slow_speed += slow * (omega - s->slow_speed);
    return s->reaction;
}

/* Least squares that forget: a torque is gain x model + drag x speed. Model and speed come in parts of their scales. */
static void learn(erc_share *of, double model, double speed, double off, double keep, double scale) {
    const double to_model = of->spread[0] * model + of->spread[1] * speed;
    const double to_speed = of->spread[1] * model + of->spread[2] * speed;
    const double per = 1.0 / (keep + model * to_model + speed * to_speed);
    const double more = of->spread[0] + of->spread[2] > MOST_SPREAD ? 1.0 : 1.0 / keep;
    of->gain = bounded(of->gain + to_model * per * off / scale, LEAST_GAIN, 1.0 / LEAST_GAIN);
    of->drag += to_speed * per * off / SPEED_SCALE;
    of->spread[0] = (of->spread[0] - to_model * to_model * per) * more;
    of->spread[1] = (of->spread[1] - to_model * to_speed * per) * more;
    of->spread[2] = (of->spread[2] - to_speed * to_speed * per) * more;
}

/* A fluid that drags so much more on the drive also pulls the output so much more without a field. */
static double by_warmth(const erc_core *core, const erc_share *learned) {
    const double known = known_drag(core);
    return known > 0.0 ? without_field(core) * (bounded(learned->drag / known, 0.0, THICKEST) - 1.0) : 0.0;
}

/* What the device gives beyond its model: a share of the torque of each clutch, and the rest by a filter. Without a
 * measured torque, and where both sides run at one speed, the rest fades. A measured torque that cannot be changes
 * nothing; where it came to light late, what was learned meanwhile goes. */
static void observe(erc_core *core) {
    const erc_config *config = &core->config;
    erc_stages *s = &core->stages;
    const bool motion = config->observer == ERC_BY_MOTION;
    const bool known = config->observer >= ERC_BY_SENSOR && isfinite(core->estimate);
    double torque = core->torque;
    if (known && motion) {
        torque = by_motion(core);
    }
    if (known && !motion) {
        s->modelled += s->late_share * (core->estimate - s->modelled);
    }
    if ((!motion && core->meter.doubted > 0u) || core->momentum.doubted > 0u) {
        s->ease = EASE; /* back to what is asked, slowly */
    }
    if (known && !motion && !s->locked && !core->meter.good && isfinite(torque)) {
        if (core->meter.unlearn) {
            s->rest = s->earlier[(core->step - ERC_STILL - 1u) % ERC_EARLIER][0];
            s->integral = s->earlier[(core->step - ERC_STILL - 1u) % ERC_EARLIER][1];
        }
        return;
    }
    if (!known || !isfinite(torque) || s->locked) {
        s->rest *= 1.0 - s->fast;
        return;
    }
    erc_share *learned = &s->learned[s->side < 0.0];
    const double omega = motion ? s->slow_speed : 0.0;
    const double off = no_larger(torque - learned->gain * s->modelled - learned->drag * omega, MOST_TORQUE);
    const bool sane = fabs(off) <= likely(core, s->modelled) && fabs(omega) <= MOST_SPEED * SPEED_SCALE;
    if (config->gain_rate > 0.0 && s->settled >= SETTLED && sane) {
        const double kept = bounded(1.0 - config->gain_rate * core->dt, LEAST_KEPT, 1.0);
        learn(learned, s->modelled / config->torque_scale, omega / SPEED_SCALE, off, kept, config->torque_scale);
    }
    s->rest += s->fast * ((motion ? by_warmth(core, learned) : off) - s->rest);
}

/* A motor speed at which the sign of the slip is known. Where both sides run at one speed a clutch passes on whatever is
 * asked of it: there the inverse is asked at the least slip that drives the wanted way. */
static double driving(erc_core *core, double wanted) {
    const double omega = core->theta.speed, alpha = core->alpha.speed, least = core->config.least_slip;
    erc_stages *s = &core->stages;
    if (core->config.device == ERC_SINGLE) {
        s->locked = fabs(omega - alpha) < least;
        return s->locked ? alpha + (wanted < 0.0 ? -least : least) : omega;
    }
    if (omega > least) {
        s->way = 1.0;
    } else if (omega < -least) {
        s->way = -1.0;
    } else {
        /* too slow to tell: the way in which it last turned */
    }
    const double output = wanted < 0.0 ? -alpha : alpha;
    s->locked = fabs(s->way * omega - output) < least;
    return s->locked ? s->way * (output + least) : omega;
}

static double lowest_field(const erc_core *core) {
    return core->config.device == ERC_SINGLE ? 0.0 : -core->config.field_limit;
}

/* At an end of the field that does not suffice. Now and then the inverse looks anew for a better field. */
static void stay_at_end(erc_stages *s, double lacking, uint32_t *events) {
    *events |= ERC_UNREACHABLE;
    s->lacking = 0.0; /* then the inverse looks anew at once */
    s->beyond = LOOK_ANEW;
    if (isfinite(lacking)) {
        s->lacking = lacking;
    }
}

/* Torque per field at a field, towards zero. */
static double slope_at(const erc_core *core, const double *in, double field, double torque) {
    const double aside = ASIDE * core->config.field_limit, inside = field < 0.0 ? field + aside : field - aside;
    const double slope = (torque - erc_at_rest(core, in, inside)) / (field - inside);
    return isfinite(slope) ? slope : 0.0;
}

/* Torque per field between two guesses of a period. 0 where the second is no better and on the same side: that is no way
 * to the wanted torque. off: the torque that each gives less the wanted one. */
static double secant(double field, double off, double next, double next_off) {
    const bool better = fabs(next_off) < fabs(off);
    const bool between = next_off * off < 0.0;
    return better || between ? (next_off - off) / (next - field) : 0.0;
}

/* Whether a guess is an end of the field, the torque lacks more of the same, and the slope there still has its sign. */
static bool ends_there(const erc_core *core, const double *in, double field, double gives, double off, double slope) {
    if (field != core->config.field_limit && field != lowest_field(core)) {
        return false;
    }
    const bool lacks = off * slope * field < 0.0;
    return lacks && slope_at(core, in, field, gives) * core->stages.slope > 0.0;
}

/* The field near the last one at which the model gives a torque at rest, by secants. Returns whether there is one, or an
 * end of the field that does not suffice. The first guess takes what the last field gave, and what the slips made of that
 * a period ago: so a smooth period asks the model once. The torque must go on changing with the field in the direction in
 * which it did where the inverse found its field. */
static bool follow(erc_core *core, const double *in, double wanted, uint32_t *events) {
    erc_stages *s = &core->stages;
    const double limit = core->config.field_limit;
    const double lowest = lowest_field(core);
    const double enough = ENOUGH * core->config.torque_scale;
    double field = s->found;
    double slope = s->slope;
    double gives = s->gave + s->turned;
    double off = gives - wanted;
    double first_off = 0.0; /* of the first guess: what slips and slope have made of the torque in this period */
    bool met = false;
    bool at_end = false;
    uint32_t guess;
    for (guess = 0u; guess < SECANTS && !met && !at_end; guess++) {
        if (!(slope * s->slope > 0.0)) {
            return false;
        }
        const double next = bounded(field - off / slope, lowest, limit);
        gives = erc_at_rest(core, in, next);
        const double next_off = gives - wanted;
        met = fabs(next_off) <= enough;
        at_end = !met && ends_there(core, in, next, gives, next_off, slope);
        if (guess == 0u) {
            first_off = next_off; /* the guess before is of another period: no slope follows from it */
        } else if (!at_end) {
            slope = secant(field, off, next, next_off);
        } else {
            /* the slope stays that of the last guess inside */
        }
        field = next;
        off = next_off;
    }
    if (!(slope * s->slope > 0.0) || !(met || at_end)) {
        return false;
    }
    s->found = field;
    s->gave = gives;
    s->slope = slope;
    s->turned = at_end ? 0.0 : s->turned + first_off;
    if (at_end) {
        stay_at_end(s, -off, events);
    }
    return true;
}

/* Whether what was out of reach of the field's end still is. */
static bool still_out_of_reach(erc_core *core, const double *in, double wanted, uint32_t *events) {
    erc_stages *s = &core->stages;
    if (s->beyond == 0u) {
        return false;
    }
    const double before = s->gave;
    s->gave = erc_at_rest(core, in, s->found);
    const bool out = (wanted - s->gave) * s->lacking > 0.0 && s->gave * before > 0.0; /* else the slip has turned */
    s->beyond = out ? s->beyond - 1u : 0u;
    s->slope = out && s->beyond == 0u ? 0.0 : s->slope;
    *events |= out ? ERC_UNREACHABLE : 0u;
    return out;
}

/* Anew, from zero field on; then the slope is there for the next time. */
static void search(erc_core *core, const double *in, double wanted, uint32_t *events) {
    erc_stages *s = &core->stages;
    const double limit = core->config.field_limit;
    double field = 0.0;
    const bool out = (erc_inverse(core, in, wanted, &field) & OUT_OF_REACH) != 0u;
    s->found = isfinite(field) ? bounded(field, lowest_field(core), limit) : 0.0;
    s->gave = erc_at_rest(core, in, s->found);
    s->turned = 0.0;
    s->beyond = 0u;
    const bool far = fabs(s->found) > AT_END * limit;
    s->slope = far || !out ? slope_at(core, in, s->found, s->gave) : 0.0;
    if (out && far) {
        stay_at_end(s, wanted - s->gave, events);
    }
    *events |= out ? ERC_UNREACHABLE : 0u;
}

/* The field at which the model gives a torque at rest. Its memory is in the lead and in the observer's comparison: the
 * inverse for the next step alone turns unstable where the model has a dead time. */
static double inverse(erc_core *core, double wanted, uint32_t *events) {
    const double omega = driving(core, wanted), alpha = core->alpha.speed;
    const double coaxial[5] = {0.0, 0.0, omega, alpha, 0.0};
    const double single[5] = {0.0, omega - alpha, 0.0, 0.0, 0.0};
    const double *in = core->config.device == ERC_SINGLE ? single : coaxial;
    if (!still_out_of_reach(core, in, wanted, events) && !follow(core, in, wanted, events)) {
        search(core, in, wanted, events);
    }
    return core->stages.found;
}

/* Of the error of the measured torque, or of the estimate; it does not wind up while the field can do no more. */
static void integrate(erc_core *core, double wanted, uint32_t events) {
    erc_stages *s = &core->stages;
    const bool measured = core->config.observer == ERC_BY_SENSOR && isfinite(core->torque);
    if (measured && !core->meter.good) {
        return;
    }
    const double most = likely(core, fabs(s->gave) + (isfinite(core->estimate) ? fabs(core->estimate) : 0.0));
    const double error = no_larger(wanted - (measured ? core->torque : core->estimate), most);
    const double next = no_larger(s->integral + s->per_period * error, MOST_TORQUE);
    const bool free = !s->locked && (events & ERC_UNREACHABLE) == 0u;
    if (isfinite(error) && (free || error * s->integral < 0.0)) {
        s->integral = free || next * s->integral > 0.0 ? next : 0.0;
    }
}

/* From one clutch to the other through zero field, and slowly after a start or a gap. */
static double handed_over(erc_core *core, double field) {
    const double limit = core->config.field_limit, most = limit / (double)EASE;
    erc_stages *s = &core->stages;
    if (field * s->side < 0.0 && fabs(field) < HAND_OVER * limit) {
        field = 0.0;
    }
    if (s->ease > 0u) {
        field = bounded(field, core->field - most, core->field + most);
        s->ease--;
    }
    if (field * s->side < 0.0) {
        s->side = -s->side;
        s->settled = 0u;
    } else {
        s->settled++;
    }
    return field;
}

/* A torque that is asked for with what a sensor adds to it. A sensor takes torque away at once; but it adds no more than
 * a tenth to what is asked without it, or asked with what it has added for a second or longer: a device changes slowly,
 * and a sensor that is wrong within what a device may be has so much field and no more. */
static double with_sensor(erc_core *core, double plain, double added) {
    erc_stages *s = &core->stages;
    const double asks = isfinite(added) ? no_larger(plain + added, MOST_TORQUE) : plain;
    if (core->config.observer != ERC_BY_SENSOR || !(fabs(plain) <= MOST_TORQUE)) {
        return asks;
    }
    const double share = s->squares > 0.0 ? bounded(s->products / s->squares, 1.0, 1.0 / LEAST_GAIN) : 1.0;
    const double usual = fabs(plain + s->usual), rule = share * fabs(plain);
    const double most = (1.0 + MORE) * (usual > rule ? usual : rule) + MORE * core->config.torque_scale;
    if (core->meter.good) {
        s->usual += s->slow * (asks - plain - s->usual);
        s->products += s->slow * (asks * plain - s->products);
        s->squares += s->slow * (plain * plain - s->squares);
    }
    return bounded(asks, -most, most);
}

double erc_torque_field(erc_core *core, double wanted, double rate, uint32_t *events) {
    erc_stages *s = &core->stages;
    begin_anew(core);
    observe(core);
    const double zero = without_field(core); /* the gain is the field's alone */
    const double plain = wanted + core->config.torque_lead * rate - zero;
    const double ask = with_sensor(core, plain, s->integral - s->rest);
    const double gain = s->learned[core->config.device != ERC_SINGLE && ask * s->way < 0.0].gain;
    const double field = inverse(core, no_larger(ask / gain + zero, MOST_TORQUE), events);
    integrate(core, wanted, *events);
    s->earlier[core->step % ERC_EARLIER][0] = s->rest;
    s->earlier[core->step % ERC_EARLIER][1] = s->integral;
    return handed_over(core, field);
}
