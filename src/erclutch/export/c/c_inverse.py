"""The inverse in C searches the field, over the effort at rest or of the next step, printed from their records.

`step_numbers` holds the same search in NumPy; the conformance tests hold the two together, bit for bit.
"""

from __future__ import annotations

from erclutch.export.c.c_printer import Printer, indented, table
from erclutch.export.exported_step import ExportedStep
from erclutch.export.step_record import (
    feels_state,
    next_record,
    search_record,
    settled_record,
    step_record,
)


def inverse(step: ExportedStep, n: str) -> str:
    """The search for a field."""
    search = step.search
    ends = [end for end in (search.plus, search.minus) if end != search.origin]
    strides = [step.precision.constant((end - search.origin) / search.segments) for end in ends]

    # Slips and further inputs within their windows, and whether one was outside.
    inputs = {f"u{place}": f"input[{place}]" for place in range(len(step.inputs))}
    printer = Printer(n, step.precision, search_record(step), inputs)
    lines = list(printer.lines())
    *held, outside = printer.results()
    lines += [f"w[{place}] = {text};" for place, text in enumerate(held)]
    lines.append(f"return ({outside}) * {n.upper()}OUTSIDE_RANGE;")
    count = _signals_at_rest(step)
    slips = f"""/* Slips and further inputs near their training ranges. */
static uint32_t {n}slips(const {n}real input[{n.upper()}INPUTS], {n}real w[{count}])
{{
{indented(lines)}
}}
"""
    parts = [
        slips,
        _miss(step, n),
        _close(step, n),
        table(f"{n}real", f"{n}steps", strides),
        _search(step, n, len(ends)),
    ]
    return "\n".join(parts)


def _state(step: ExportedStep, n: str) -> str:
    """The parameter of the state, ahead of others; only where it makes a difference."""
    return f"const {n}state *state, " if feels_state(step) else ""


def _state_given(step: ExportedStep) -> str:
    """The state as an argument, ahead of others."""
    return "state, " if feels_state(step) else ""


def held_count(step: ExportedStep) -> int:
    """Length of the array of what the search holds: slips and further inputs at rest, all inputs of the next step."""
    return len(step.inputs) if feels_state(step) else _signals_at_rest(step)


def _signals_at_rest(step: ExportedStep) -> int:
    """How many slips and further inputs there are."""
    return step.elements + len(step.extras)


def _miss(step: ExportedStep, n: str) -> str:
    """By how much a field misses the wanted effort, and the magnitude of a number."""
    zero = f"0.0{step.precision.suffix}"
    count = _signals_at_rest(step)
    names = {f"w{place}": f"w[{place}]" for place in range(count)}
    printer = Printer(n, step.precision, settled_record(step), names)
    name, of_next = "miss", ""
    if feels_state(step):
        # The effort of the next step, and which of the two the search looks at.
        name = "rest_miss"
        inputs = {f"u{i}": f"input[{i}]" for i in range(len(step.inputs))}
        next_printer = Printer(
            n, step.precision, next_record(step), inputs, step_record(step).record
        )
        given = len(step.inputs)
        of_next = f"""
/* Effort of the next step for a signed field, less the wanted one; the state stays as it is. */
static {n}real {n}next_miss(const {n}state *state, {n}real field, const {n}real input[{given}], {n}real wanted)
{{
{_difference(next_printer)}
}}

/* Without a state: at rest. */
static {n}real {n}miss(const {n}state *state, {n}real field, const {n}real w[{given}], {n}real wanted)
{{
    return (state != NULL) ? {n}next_miss(state, field, w, wanted) : {n}rest_miss(field, w, wanted);
}}
"""
    return f"""/* Effort at rest for a signed field, less the wanted one. */
static {n}real {n}{name}({n}real field, const {n}real w[{count}], {n}real wanted)
{{
{_difference(printer)}
}}
{of_next}
static {n}real {n}magnitude({n}real x)
{{
    return (x < {zero}) ? -x : x;
}}
"""


def _difference(printer: Printer) -> str:
    """The body of a miss: the effort of a record, less the wanted one."""
    lines = list(printer.lines())
    effort = printer.results()[0]
    return indented([*lines, f"return ({effort}) - wanted;"])


def _close(step: ExportedStep, n: str) -> str:
    search = step.search
    w = held_count(step)
    suffix = step.precision.suffix
    zero = f"0.0{suffix}"
    half = f"0.5{suffix}"
    tolerance = step.precision.constant(search.tolerance)
    width = step.precision.constant(search.width)
    state = _state(step, n)
    given = _state_given(step)
    most = search.most
    about = f"The field between a and b where the miss crosses zero: secants and halvings in turn, {most} at most"
    return f"""/* {about}. */
static {n}real {n}close({state}const {n}real w[{w}], {n}real wanted, const {n}real from[2], const {n}real to[2])
{{
    {n}real a = from[0];
    {n}real miss_a = from[1];
    {n}real b = to[0];
    {n}real miss_b = to[1];
    {n}real x = {half} * (a + b);
    uint32_t i;
    uint32_t open = 1u;
    for (i = 0u; (i < {most}u) && (open != 0u); i++)
    {{
        const {n}real middle = {half} * (a + b);
        const {n}real secant = b - (miss_b * ((b - a) / (miss_b - miss_a)));
        const {n}real low = (a < b) ? a : b;
        const {n}real high = (a < b) ? b : a;
        {n}real miss;
        x = middle;
        if (((i & 1u) == 0u) && (low < secant) && (secant < high))
        {{
            /*@ assert !\\is_NaN(secant); */
            x = secant;
        }}
        miss = {n}miss({given}x, w, wanted);
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
        if (({n}magnitude(miss) <= {tolerance}) || ({n}magnitude(b - a) <= {width}))
        {{
            open = 0u;
        }}
    }}
    return x;
}}
"""


def _search(step: ExportedStep, n: str, sides: int) -> str:
    search = step.search
    w = held_count(step)
    zero = f"0.0{step.precision.suffix}"
    origin = step.precision.constant(search.origin)
    tolerance = step.precision.constant(search.tolerance)
    state = _state(step, n)
    given = _state_given(step)
    return f"""/* Brackets outward from {search.origin:.6g}, so the field found is the one nearest to it. */
static uint32_t {n}search({state}const {n}real w[{w}], {n}real wanted, {n}real *field)
{{
    {n}real left[{sides}][2];
    {n}real best = {origin};
    {n}real best_miss = {n}miss({given}best, w, wanted);
    uint32_t i;
    uint32_t side;
    uint32_t done;
    for (side = 0u; side < {sides}u; side++)
    {{
        left[side][0] = best;
        left[side][1] = best_miss;
    }}
    best_miss = {n}magnitude(best_miss);
    done = (best_miss <= {tolerance}) ? (uint32_t)1u : (uint32_t)0u;
    for (i = 1u; (i <= {search.segments}u) && (done == 0u); i++)
    {{
        for (side = 0u; (side < {sides}u) && (done == 0u); side++)
        {{
            {n}real right[2];
            right[0] = {origin} + (({n}real)i * {n}steps[side]);
            right[1] = {n}miss({given}right[0], w, wanted);
            if (((left[side][1] <= {zero}) && (right[1] >= {zero})) ||
                ((left[side][1] >= {zero}) && (right[1] <= {zero})))
            {{
                best = {n}close({given}w, wanted, left[side], right);
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
