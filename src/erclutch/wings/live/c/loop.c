/* erclutch-loop: sense, control, interlock, estimate, command, once a period, in a process of its own.
 *
 * Whatever ends it (signal, order, lost parent, its own crash) ends at zero field; if nothing of it is left to send that,
 * the rig's watchdog does it. Started by `erclutch live`; by hand:
 *
 *     erclutch-loop --config C --ring R --udp HOST PORT LOCAL_PORT SESSION [--library PATH OPTIONS] [--model LIB DIGEST]
 *                   [--table T] [--orders FD] [--steps N] [--priority 80] [--cpu N]
 */
#define _GNU_SOURCE
#include "erc_config.h"
#include "erc_core.h"
#include "erc_model.h"
#include "erc_packet.h"
#include "erc_realtime.h"
#include "erc_rig.h"
#include "erc_ring.h"
#include "erc_start.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define STEPS_AT_ZERO 5u /* commands of zero field before it ends: one of them arrives even on a bad line */

typedef struct {
    const char *config, *ring, *table;
    const char *udp[4], *library[2], *model[2]; /* model: its library and its digest */
    int orders, priority, cpu;
    uint64_t steps;
} options_t;

static volatile sig_atomic_t stop_asked;
static erc_rig *rig_in_use; /* for the handler of fatal signals */
static erc_command last_command;

/* --- start ------------------------------------------------------------------------------------------------------- */

static uint64_t number(const char *text, const char *option) {
    char *end;
    errno = 0;
    const uint64_t value = strtoull(text, &end, 10);
    if (errno != 0 || end == text || *end != '\0' || text[0] == '-') {
        erc_fail("%s takes a whole number, not %s", option, text);
    }
    return value;
}

static options_t options_of(int count, char **words) {
    options_t out = {.model = {0, ""}};
    const char *orders = 0, *steps = 0, *priority = 0, *cpu = 0;
    const struct {
        const char *name;
        size_t values;
        const char **to;
    } known[] = {{"--config", 1, &out.config}, {"--ring", 1, &out.ring},  {"--udp", 4, out.udp},
                 {"--library", 2, out.library}, {"--model", 2, out.model}, {"--table", 1, &out.table},
                 {"--orders", 1, &orders},      {"--steps", 1, &steps},    {"--priority", 1, &priority},
                 {"--cpu", 1, &cpu}};
    for (int i = 1; i < count;) {
        size_t which = 0;
        while (which < sizeof known / sizeof known[0] && strcmp(words[i], known[which].name) != 0) {
            which++;
        }
        if (which == sizeof known / sizeof known[0] || i + (int)known[which].values >= count) {
            erc_fail("unknown or incomplete option %s", words[i]);
        }
        memcpy(known[which].to, &words[i + 1], known[which].values * sizeof words[0]);
        i += 1 + (int)known[which].values;
    }
    if (out.config == 0 || out.ring == 0 || (out.udp[0] == 0) == (out.library[0] == 0)) {
        erc_fail("--config, --ring and one of --udp, --library are needed");
    }
    out.orders = orders == 0 ? -1 : (int)number(orders, "--orders");
    out.steps = steps == 0 ? UINT64_MAX : number(steps, "--steps");
    out.priority = priority == 0 ? 80 : (int)number(priority, "--priority");
    out.cpu = cpu == 0 ? -1 : (int)number(cpu, "--cpu");
    return out;
}

static const erc_row *table_of(const char *path, uint64_t *rows) {
    size_t size = 0;
    const erc_row *table = path == 0 ? 0 : erc_file_map(path, 0, &size);
    if (size % sizeof(erc_row) != 0) {
        erc_fail("%s is no table of rows of %zu bytes", path, sizeof(erc_row));
    }
    *rows = size / sizeof(erc_row);
    return table;
}

static void read_config(const char *path, uint64_t rows, erc_config *config) {
    FILE *file = fopen(path, "rb");
    if (file == 0 || fread(config, sizeof *config, 1, file) != 1 || fgetc(file) != EOF) {
        erc_fail("%s is no configuration of %zu bytes", path, sizeof *config);
    }
    (void)fclose(file);
    if (config->crc != erc_crc32(config, sizeof *config - sizeof config->crc)) {
        erc_fail("%s is damaged: its checksum does not fit", path);
    }
    const char *error = erc_config_error(config, rows);
    if (error != 0) {
        erc_fail("%s: %s", path, error);
    }
}

/* --- end --------------------------------------------------------------------------------------------------------- */

static void on_stop(int signal_number) {
    (void)signal_number;
    stop_asked = 1;
}

/* Our own crash, in a model for instance: only calls that are safe here. */
static void on_crash(int signal_number) {
    if (rig_in_use != 0 && rig_in_use->socket >= 0) {
        erc_command zero = {last_command.seq + 1u, last_command.time_ns, 0.0, 0.0, 0.0, 1u, last_command.device};
        (void)erc_rig_send(rig_in_use, &zero);
    }
    (void)signal(signal_number, SIG_DFL);
    (void)raise(signal_number);
}

static void handle_signals(void) {
    static const int stops[] = {SIGTERM, SIGINT, SIGHUP, SIGQUIT};
    static const int crashes[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
    static char room[32768];
    const stack_t stack = {.ss_sp = room, .ss_size = sizeof room};
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_stop;
    for (size_t i = 0; i < sizeof stops / sizeof stops[0]; i++) {
        (void)sigaction(stops[i], &action, 0);
    }
    (void)sigaltstack(&stack, 0);
    action.sa_handler = on_crash;
    action.sa_flags = SA_ONSTACK | (int)SA_RESETHAND;
    for (size_t i = 0; i < sizeof crashes / sizeof crashes[0]; i++) {
        (void)sigaction(crashes[i], &action, 0);
    }
    (void)signal(SIGPIPE, SIG_IGN);
}

/* --- orders ------------------------------------------------------------------------------------------------------ */

/* At most a few a step. A pipe delivers them whole; what is no order is counted and dropped. 1 if the loop is to end. */
static int take_orders(int *file, erc_core *core) {
    erc_order order;
    struct pollfd ready = {*file, POLLIN, 0};
    for (unsigned i = 0; i < 4u && *file >= 0 && poll(&ready, 1, 0) > 0; i++) {
        const ssize_t size = read(*file, &order, sizeof order);
        if (size == 0) {
            return 1; /* whoever gave orders is gone */
        }
        if (size != (ssize_t)sizeof order || order.magic != ERC_ORDER_MAGIC ||
            order.crc != erc_crc32(&order, sizeof order - sizeof order.crc)) {
            core->pending |= ERC_ORDER_REFUSED;
            continue;
        }
        if (erc_core_order(core, &order)) {
            return 1;
        }
    }
    return 0;
}

/* --- the loop ---------------------------------------------------------------------------------------------------- */

static void tell(erc_ring *ring, const erc_core *core) {
    ring->header->state = core->state;
    ring->header->trip_reason = core->trip_reason;
    ring->header->program = core->program;
    ring->header->mode = core->config.list[core->program].mode;
    ring->header->sensor_seq = core->sensor_seq;
}

static int32_t clipped(int64_t value) {
    return value > INT32_MAX ? INT32_MAX : (value < INT32_MIN ? INT32_MIN : (int32_t)value);
}

/* One step; `carried` are events of input and output that came up after the last frame was made. Returns those of now. */
static uint32_t step(erc_core *core, erc_rig *rig, erc_ring *ring, uint64_t tick, uint64_t deadline, uint32_t carried) {
    static erc_sample samples[ERC_MOST_SAMPLES];
    erc_frame frame;
    const uint64_t woken = erc_now();
    const int64_t late = (int64_t)(woken - deadline);
    uint32_t events = carried;
    const uint32_t count = erc_rig_receive(rig, samples, &events);
    erc_core_step(core, samples, count, tick, late > 0 ? (uint64_t)late : 0u, events, &last_command, &frame);
    last_command.seq++;
    last_command.time_ns = woken;
    const uint32_t sent = erc_rig_send(rig, &last_command);
    frame.time_ns = woken;
    frame.lateness_ns = clipped(late);
    frame.step_ns = (uint32_t)clipped((int64_t)(erc_now() - woken));
    erc_ring_write(ring, &frame);
    tell(ring, core);
    return sent;
}

static void run(const options_t *options, erc_core *core, erc_rig *rig, erc_ring *ring) {
    const uint64_t period = core->config.period_ns;
    const pid_t parent = getppid();
    int orders = options->orders;
    uint64_t tick = 0u, deadline = erc_now() + 2u * period;
    unsigned at_zero = 0u;
    uint32_t carried = 0u, skipped = 0u;
    while (at_zero < STEPS_AT_ZERO) {
        erc_sleep_until(deadline);
        if (stop_asked || tick >= options->steps || getppid() != parent || take_orders(&orders, core)) {
            erc_core_stop(core);
            orders = -1;
            stop_asked = 1;
        }
        ring->header->missed += skipped;
        carried = step(core, rig, ring, tick, deadline, carried);
        at_zero += core->stopping;
        /* Deadlines stay on their grid: what was missed is skipped, not caught up with. */
        const uint64_t now = erc_now();
        const uint64_t periods = now > deadline ? (now - deadline) / period + 1u : 1u;
        skipped = (uint32_t)(periods - 1u);
        deadline += periods * period;
        tick += periods;
    }
    ring->header->state = ERC_STOPPED;
}

int main(int count, char **words) {
    static erc_core core;
    static erc_config config;
    const options_t options = options_of(count, words);
    uint64_t rows;
    const erc_row *table = table_of(options.table, &rows);
    read_config(options.config, rows, &config);
    erc_model model = {0, 0, 0, 0, 0};
    if (options.model[0] != 0) {
        model = erc_model_load(options.model[0], options.model[1], config.device);
    }
    erc_core_init(&core, &config, table, &model);
    erc_ring ring = erc_ring_open(options.ring);
    const char *const *udp = options.udp;
    erc_rig rig = udp[0] != 0 ? erc_rig_udp(udp[0], udp[1], udp[2], udp[3], config.device)
                              : erc_rig_library(options.library[0], options.library[1]);
    handle_signals();
    rig_in_use = &rig;
    erc_go_realtime(options.priority, options.cpu, ring.header->realtime, sizeof ring.header->realtime);
    ring.header->pid = (uint32_t)getpid();
    run(&options, &core, &rig, &ring);
    rig_in_use = 0;
    erc_rig_end(&rig);
    return 0;
}
