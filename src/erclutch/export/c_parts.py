"""The pieces of the C file that are the same for every model but for their numbers: state, filter, lag, inverse.

`emulate` holds the same algorithms in NumPy; the conformance tests hold the two together, bit for bit.
"""

from __future__ import annotations

from erclutch.export.c_code import Printer, table
from erclutch.export.graph import traced
from erclutch.export.program import LARGEST_ANGLE, Program, Window
from erclutch.precision import Precision


def bits(n: str, p: Precision) -> str:
    """Numbers as bits and back."""
    exponent = f"0x{((1 << (p.width - 1 - p.fraction)) - 1) << p.fraction:x}{p.bits_suffix}"
    return f"""/* A number and its bits. The two members have the same size, so the order of bytes does not matter. */
typedef union {{ {n}real real; {p.c_bits} bits; }} {n}pun;

static {p.c_bits} {n}bits_of({n}real x)
{{
    {n}pun pun;
    pun.real = x;
    return pun.bits;
}}

/* Neither infinite nor NaN, told by the bits: no compiler option can take it away. */
static uint32_t {n}finite({n}real x)
{{
    return (({n}bits_of(x) & {exponent}) != {exponent}) ? (uint32_t)1u : (uint32_t)0u;
}}
"""


def real_of_bits(n: str, p: Precision) -> str:
    """The number with these bits."""
    return f"""static {n}real {n}real_of_bits({p.c_bits} u)
{{
    {n}pun pun;
    pun.bits = u;
    return pun.real;
}}
"""


_ABOUT = {
    "absolute": "|x|",
    "exp": "e^x = 2^k (1 + r + r^2 P(r)) for x = k ln 2 + r",
    "exp_hold": "The argument of exp within what it can do",
    "exp_held": "e^x = 2^k (1 + r + r^2 P(r)) for x = k ln 2 + r, x held",
    "expm1": "e^x - 1, precise near zero",
    "tanh_hold": "The argument of tanh within where it is not yet 1",
    "tanh_held": "Hyperbolic tangent of a held argument",
    "tanh": "Hyperbolic tangent",
    "power": "x^n = e^(n log x) for x > 0; log x and its product with n as sums of two numbers",
}


def function(n: str, name: str, p: Precision) -> str:
    """One elementary function."""
    graph = traced(name, p)
    printer = Printer(n, p, {"x": "x", "n": "n"})
    lines = list(printer.lines(graph))
    arguments = f"{n}real x, {n}real n" if name == "power" else f"{n}real x"
    body = "\n".join(f"    {line}" for line in [*lines, f"return {printer.results(graph)[0]};"])
    return f"/* {_ABOUT[name]}. */\nstatic {n}real {n}{name}({arguments})\n{{\n{body}\n}}\n"


def windows(n: str) -> str:
    """Flags and holds of one signal."""
    return f"""/* Holds a value within [limits[2], limits[3]]; tells one outside [limits[0], limits[1]]. */
static uint32_t {n}take({n}real value, const {n}real limits[4], {n}real *held)
{{
    uint32_t flags = 0u;
    *held = value;
    if ((value < limits[0]) || (limits[1] < value))
    {{
        const {n}real below = (value < limits[3]) ? value : limits[3];
        *held = (limits[2] < below) ? below : limits[2];
        flags = {n.upper()}OUTSIDE_RANGE;
    }}
    return flags;
}}
"""


def limits(n: str, name: str, window: Window, p: Precision) -> str:
    """Table of a window."""
    return table(f"{n}real", f"{n}{name}", [p.constant(v) for v in (*window.warn, *window.hold)])


def fields(program: Program, n: str) -> str:
    """Fields of the elements, and flags about them."""
    e, p = program.elements, program.precision
    both = ""
    if e == 2:
        both = f"""    if (({p.constant(program.both)} < in[0]) && ({p.constant(program.both)} < in[1]))
    {{
        flags |= {n.upper()}BOTH_FIELDS;
    }}
"""
    taken = "\n".join(f"    flags |= {n}take(in[{i}], {n}field_limits, &x[{i}]);" for i in range(e))
    return f"""static uint32_t {n}fields(const {n}real in[{n.upper()}INPUTS], {n}real x[{e}])
{{
    uint32_t flags = 0u;
{taken}
{both}    return flags;
}}
"""


def slips(program: Program, n: str) -> str:
    """Slips of the elements and further inputs, and flags about them."""
    e, extras = program.elements, len(program.extras)
    if e == 2:
        lines = ["/* w1 = theta_dot - alpha_dot, w2 = -theta_dot - alpha_dot */"]
        lines += [f"flags |= {n}take(in[2] - in[3], {n}slip_limits, &w[0]);"]
        lines += [f"flags |= {n}take((-in[2]) - in[3], {n}slip_limits, &w[1]);"]
    else:
        lines = [f"flags |= {n}take(in[1], {n}slip_limits, &w[0]);"]
    lines += [f"flags |= {n}take(in[{2 * e + k}], {n}extra{k}_limits, &w[{e + k}]);" for k in range(extras)]
    body = "\n".join(f"    {line}" for line in lines)
    return f"""static uint32_t {n}slips(const {n}real in[{n.upper()}INPUTS], {n}real w[{e + extras}])
{{
    uint32_t flags = 0u;
{body}
    return flags;
}}
"""


def speeds(program: Program, n: str) -> str:
    """The filter from angles to speeds."""
    f, p = program.filter, program.precision
    if f is None:
        return ""
    k = p.constant
    period = k(program.period or 0.0)
    turned = (
        f"""static {n}real {n}turned({n}real x)
{{
    const {n}real turns = ((x * {k(1.0 / f.turn)}) + {k(1.5 * 2.0**p.fraction)}) - {k(1.5 * 2.0**p.fraction)};
    return x - (turns * {k(f.turn)});
}}
"""
        if f.turn
        else f"""static {n}real {n}turned({n}real x)
{{
    return x;
}}
"""
    )
    what = "An angle less whole turns, within half a turn of zero" if f.turn else "A position has no turns"
    return f"""/* {what}. */
{turned}
/* Speed from position, filter {f.name}: the prediction position + period speed, corrected by the innovation with gains
   g = {f.g:.17g} and h / period, h = {f.h:.17g}. A bad reading is no innovation. */
static {n}real {n}speed({n}state *state, uint32_t k, {n}real measured, uint32_t good)
{{
    if (state->started == 0u)
    {{
        state->position[k] = {n}turned(measured);
        state->speed[k] = 0.0{p.suffix};
    }}
    else
    {{
        const {n}real predicted = state->position[k] + ({period} * state->speed[k]);
        const {n}real innovation = (good != 0u) ? {n}turned(measured - predicted) : 0.0{p.suffix};
        state->position[k] = {n}turned(predicted + ({k(f.g)} * innovation));
        state->speed[k] = state->speed[k] + (({k(f.h)} * innovation) / {period});
    }}
    return state->speed[k];
}}
"""


def accept(program: Program, n: str) -> str:
    """The last good row."""
    e, angles = program.elements, program.filter is not None
    plain = [i for i in range(len(program.inputs)) if not (angles and e <= i < 2 * e)]
    copy = "\n".join(f"        state->last[{i}] = input[{i}];" for i in plain)
    large = program.precision.constant(LARGEST_ANGLE)
    finite = " & ".join(f"{n}finite(input[{i}])" for i in range(len(program.inputs)))
    index = "    uint32_t i;" if angles else ""
    check = (
        f"""
    for (i = {e}u; i < {2 * e}u; i++)
    {{
        if (!((-{large} < input[i]) && (input[i] < {large})))
        {{
            good = 0u;
        }}
    }}"""
        if angles
        else ""
    )
    run = (
        f"""
    if ((good | state->started) != 0u)
    {{
        for (i = 0u; i < {e}u; i++)
        {{
            state->last[i + {e}u] = {n}speed(state, i, input[i + {e}u], good);
        }}
    }}"""
        if angles
        else ""
    )
    return f"""/* Keeps the row if all of it is usable; the last good one stays otherwise. */
static uint32_t {n}accept({n}state *state, const {n}real input[{n.upper()}INPUTS])
{{
    uint32_t good = {finite};
{index}{check}
    if (good != 0u)
    {{
{copy}
    }}{run}
    state->started |= good;
    return (good != 0u) ? (uint32_t)0u : {n.upper()}NON_FINITE;
}}
"""


def respond(program: Program, n: str) -> str:
    """Lag and delay."""
    lag, p, e = program.lag, program.precision, program.elements
    if lag is None:
        return ""
    k = p.constant
    if lag.fall is None:
        choice = f"        const {n}real share = {k(lag.rise)};\n        const {n}real tau = {k(lag.tau_rise)};"
    else:
        choice = f"""        const {n}real grown = (u[i] - before) * before;
        const uint32_t rising = (grown >= 0.0{p.suffix}) ? (uint32_t)1u : (uint32_t)0u;
        const {n}real share = (rising != 0u) ? {k(lag.rise)} : {k(lag.fall)};
        const {n}real tau = (rising != 0u) ? {k(lag.tau_rise)} : {k(lag.tau_fall)};"""
    times = (
        f"tau = {lag.tau_rise:.9g} s"
        if lag.fall is None
        else (f"tau = {lag.tau_rise:.9g} s while |x| grows, {lag.tau_fall:.9g} s while it shrinks")
    )
    return f"""/* The field in the fluid: x' = (u - x) / tau, then a delay; {times}.
   Between two rows x is a cubic through its values and slopes. */
static void {n}respond({n}state *state, {n}real u[{e}])
{{
    uint32_t i;
    uint32_t j;
    const uint32_t at = state->at;
    const uint32_t oldest = ((at + 1u) < {lag.rows}u) ? (at + 1u) : 0u;
    const uint32_t next = ((oldest + 1u) < {lag.rows}u) ? (oldest + 1u) : 0u;
    for (i = 0u; i < {e}u; i++)
    {{
        const {n}real before = (state->settled != 0u) ? state->lag[i] : u[i];
{choice}
        if (state->settled != 0u)
        {{
            state->lag[i] = (share * u[i]) - ((share - 1.0{p.suffix}) * before);
        }}
        else
        {{
            state->lag[i] = u[i];
            for (j = 0u; j < {lag.rows}u; j++)
            {{
                state->history[i][j] = u[i];
                state->slope[i][j] = 0.0{p.suffix};
            }}
        }}
        state->history[i][at] = state->lag[i];
        state->slope[i][at] = (u[i] - state->lag[i]) / tau;
        {{
            const {n}real first = state->history[i][oldest];
            const {n}real bend =
                (state->slope[i][oldest] * {k(lag.bend_before)}) + (state->slope[i][next] * {k(lag.bend_after)});
            u[i] = (first + ((state->history[i][next] - first) * {k(lag.forward)})) + (bend * {k(lag.reach)});
        }}
    }}
    state->at = oldest;
}}
"""


def limited(program: Program, n: str) -> str:
    """The effort within its limits."""
    low, high = (program.precision.constant(v) for v in program.limits)
    return f"""/* The effort within its limits; the one before where it is not finite. */
static uint32_t {n}limited({n}real value, {n}real *effort)
{{
    uint32_t flags = {n.upper()}LIMITED;
    if ({n}finite(value) != 0u)
    {{
        const {n}real below = (value < {high}) ? value : {high};
        *effort = ({low} < below) ? below : {low};
        flags = ((value < {low}) || ({high} < value)) ? {n.upper()}LIMITED : (uint32_t)0u;
    }}
    return flags;
}}
"""


def inverse(program: Program, n: str) -> str:
    """The search for a field."""
    s, k = program.search, program.precision.constant
    ends = [end for end in (s.plus, s.minus) if end != s.origin]
    steps = table(f"{n}real", f"{n}steps", [k((end - s.origin) / s.segments) for end in ends])
    return "\n".join([_miss(program, n), _close(program, n), steps, _search(program, n, len(ends))])


def _miss(program: Program, n: str) -> str:
    e, zero, w = program.elements, f"0.0{program.precision.suffix}", program.elements + len(program.extras)
    apart = f"    x[0] = {n}command(field);"
    if e == 2:
        apart = f"""    x[0] = {n}command(({zero} < field) ? field : {zero});
    x[1] = {n}command((field < {zero}) ? -field : {zero});"""
    return f"""/* Effort at rest for a signed field, less the wanted one. */
static {n}real {n}miss({n}real field, const {n}real w[{w}], {n}real wanted)
{{
    {n}real x[{e}];
{apart}
    return {n}rest(x, w) - wanted;
}}

static {n}real {n}magnitude({n}real x)
{{
    return (x < {zero}) ? -x : x;
}}
"""


def _close(program: Program, n: str) -> str:
    s, p, w = program.search, program.precision, program.elements + len(program.extras)
    k, zero = p.constant, f"0.0{p.suffix}"
    about = f"The field between a and b where the miss crosses zero: secants and halvings in turn, {s.most} at most"
    return f"""/* {about}. */
static {n}real {n}close(const {n}real w[{w}], {n}real wanted, const {n}real from[2], const {n}real to[2])
{{
    {n}real a = from[0];
    {n}real miss_a = from[1];
    {n}real b = to[0];
    {n}real miss_b = to[1];
    {n}real x = 0.5{p.suffix} * (a + b);
    uint32_t i;
    uint32_t open = 1u;
    for (i = 0u; (i < {s.most}u) && (open != 0u); i++)
    {{
        const {n}real middle = 0.5{p.suffix} * (a + b);
        const {n}real secant = b - (miss_b * ((b - a) / (miss_b - miss_a)));
        const {n}real low = (a < b) ? a : b;
        const {n}real high = (a < b) ? b : a;
        const uint32_t inside = ((low < secant) && (secant < high)) ? (uint32_t)1u : (uint32_t)0u;
        {n}real miss;
        x = ((inside != 0u) && ((i & 1u) == 0u)) ? secant : middle;
        miss = {n}miss(x, w, wanted);
        if ((miss < {zero}) == (miss_a < {zero}))
        {{
            a = x;
            miss_a = miss;
        }}
        else
        {{
            b = x;
            miss_b = miss;
        }}
        if (({n}magnitude(miss) <= {k(s.tolerance)}) || ({n}magnitude(b - a) <= {k(s.width)}))
        {{
            open = 0u;
        }}
    }}
    return x;
}}
"""


def _search(program: Program, n: str, sides: int) -> str:
    s, p, w = program.search, program.precision, program.elements + len(program.extras)
    k, zero = p.constant, f"0.0{p.suffix}"
    return f"""/* Brackets outward from {_short(s.origin)}, so the field found is the one nearest to it. */
static uint32_t {n}search(const {n}real w[{w}], {n}real wanted, {n}real *field)
{{
    {n}real left[{sides}][2];
    {n}real best = {k(s.origin)};
    {n}real best_miss = {n}miss(best, w, wanted);
    uint32_t i;
    uint32_t side;
    uint32_t done;
    for (side = 0u; side < {sides}u; side++)
    {{
        left[side][0] = best;
        left[side][1] = best_miss;
    }}
    best_miss = {n}magnitude(best_miss);
    done = (best_miss <= {k(s.tolerance)}) ? (uint32_t)1u : (uint32_t)0u;
    for (i = 1u; (i <= {s.segments}u) && (done == 0u); i++)
    {{
        for (side = 0u; (side < {sides}u) && (done == 0u); side++)
        {{
            {n}real right[2];
            right[0] = {k(s.origin)} + (({n}real)i * {n}steps[side]);
            right[1] = {n}miss(right[0], w, wanted);
            if (((left[side][1] <= {zero}) && (right[1] >= {zero})) ||
                ((left[side][1] >= {zero}) && (right[1] <= {zero})))
            {{
                best = {n}close(w, wanted, left[side], right);
                done = 1u;
            }}
            else if ({n}magnitude(right[1]) < best_miss)
            {{
                best = right[0];
                best_miss = {n}magnitude(right[1]);
            }}
            else
            {{
                /* farther off than what is known */
            }}
            left[side][0] = right[0];
            left[side][1] = right[1];
        }}
    }}
    *field = best;
    return (done != 0u) ? (uint32_t)0u : {n.upper()}OUT_OF_REACH;
}}
"""


def _short(value: float) -> str:
    return f"{value:.6g}"
