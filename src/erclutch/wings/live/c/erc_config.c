/* Whether a configuration can be. What is wrong with it stands before a semicolon, and its remedy after it. */
#include "erc_config.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

static int positive(double x) {
    return isfinite(x) && x > 0.0;
}

static int not_negative(double x) {
    return isfinite(x) && x >= 0.0;
}

static char text[200]; /* of what is wrong; until the next call */

/* Where each setting stands, and how it may be. */
static const struct {
    const char *name;
    size_t at;
    uint32_t kind;
} SETTINGS[] = {
#define ERC_SETTING(kind, name) {#name, offsetof(erc_config, name), ERC_##kind},
#include "erc_settings.h"
#undef ERC_SETTING
};

/* What is wrong with a setting, before its remedy; 0 if nothing is. */
static const char *setting_error(const erc_config *config) {
    static const double LEAST[] = {ERC_LEAST, 0.0, -ERC_MOST};
    static const char *const LEAST_SAID[] = {"a number above 0", "0 or a number above", "a finite number"};
    for (size_t i = 0; i < sizeof SETTINGS / sizeof SETTINGS[0]; i++) {
        double value;
        memcpy(&value, (const char *)config + SETTINGS[i].at, sizeof value);
        const double least = LEAST[SETTINGS[i].kind];
        if (!(value >= least && value <= ERC_MOST)) {
            (void)snprintf(text, sizeof text, "%s is %g; Give %s, at most %g", SETTINGS[i].name, value,
                           LEAST_SAID[SETTINGS[i].kind], ERC_MOST);
            return text;
        }
    }
    return 0;
}

static const char *program_error(const erc_program *program, uint32_t device, uint64_t rows) {
    if (program->mode > ERC_WALL || program->shape > ERC_TABLE) {
        return "a program of an unknown kind; Give one of those of erc_layout.h";
    }
    if (program->mode == (device == ERC_SINGLE ? ERC_IMPEDANCE : ERC_WALL)) {
        return "an impedance for a single device, or a wall for a pair; An impedance needs the pair, a wall a single device";
    }
    if (!isfinite(program->amplitude) || !isfinite(program->offset) || !isfinite(program->motor_torque) ||
        !not_negative(program->frequency) || !not_negative(program->soft)) {
        return "a program with a number that is not finite, or a negative frequency; Give finite numbers, and a frequency from 0";
    }
    if (program->shape == ERC_TABLE &&
        (program->rows == 0u || program->first > rows || program->rows > rows - program->first)) {
        return "a program outside the table; Give rows that the table has";
    }
    return 0;
}

const char *erc_config_error(const erc_config *config, uint64_t table_rows) {
    if (config->magic != ERC_CONFIG_MAGIC || config->version != ERC_CONFIG_VERSION || config->size != sizeof *config) {
        return "not a configuration of this version; Start the loop by the erclutch that it comes with";
    }
    if (config->device > ERC_SINGLE || config->period_ns < 100000u || config->period_ns > 1000000000u) {
        return "an unknown device, or a period outside 0.1 ms to 1 s; Give coaxial or single, and 0.1 ms to 1 s";
    }
    if (!positive(config->filter_g) || config->filter_g > 1.0 || !positive(config->filter_h) || config->filter_h > 2.0) {
        return "gains of the speed filter outside 0 to 1 and 0 to 2; Give another bandwidth";
    }
    const char *setting = setting_error(config);
    if (setting != 0) {
        return setting;
    }
    if (config->observer > ERC_BY_MOTION) {
        return "an unknown observer; Give off, none, sensor or motion";
    }
    if (0.5e-9 * (double)config->period_ns * config->stiffness > config->damping) {
        (void)snprintf(text, sizeof text,
                       "a stiffness of %g N m/rad, sampled each %g ms, gives energy away; Give at most 2 damping / period, "
                       "%g N m/rad, or more damping",
                       config->stiffness, 1e-6 * (double)config->period_ns,
                       2e9 * config->damping / (double)config->period_ns);
        return text;
    }
    if (config->trip_samples <= ERC_ZERO_BEFORE_TRIP || config->trip_samples > 21u ||
        config->hold_samples >= config->trip_samples - ERC_ZERO_BEFORE_TRIP) {
        return "hold and trip that do not go together; Give 0 <= hold < trip - 7 and trip <= 21";
    }
    if (config->programs < 1u || config->programs > ERC_PROGRAMS || config->program >= config->programs) {
        return "no program, too many, or a start with one that is not there; Give 1 to 32 programs";
    }
    for (uint32_t i = 0; i < config->programs; i++) {
        const char *error = program_error(&config->list[i], config->device, table_rows);
        if (error != 0) {
            return error;
        }
    }
    return 0;
}
