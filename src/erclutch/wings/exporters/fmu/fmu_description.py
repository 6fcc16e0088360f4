"""This module writes the modelDescription.xml of FMI 2.0 and FMI 3.0: what both say, and how each of them says it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

from erclutch._version import __version__
from erclutch.errors import ErclutchError
from erclutch.export.c.c_source import FLAGS, header, source
from erclutch.export.exported_step import ExportedStep
from erclutch.export.step_record import has_memory

_BASE = {"kilogram": "kg", "meter": "m", "second": "s", "ampere": "A", "kelvin": "K", "mole": "mol", "candela": "cd"}


@dataclass(frozen=True)
class Port:
    """A variable of an FMU.

    Attributes:
        name, unit: as in the model; an unknown unit is left out.
        limits: smallest and largest value, None where there are none.
        start: value ahead of the first sample.
        meaning: for people.
    """

    name: str
    unit: str
    limits: tuple[float, float] | None
    start: float = 0.0
    meaning: str = ""


@dataclass(frozen=True)
class Interface:
    """What an FMU shows of the C inside.

    Attributes:
        inputs, outputs, parameters: its variables, in the order of their value references.
        variability: of the parameters, fixed or tunable.
        sampled: whether the C has a memory, and so a period.
        flags: sum of all flags that can be raised, and what they mean.
        code: the C's .c and .h.
        binding: what binds ``core.h`` to them: ``erc_reset``, ``erc_step``, ``erc_use`` and their types.
    """

    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    parameters: tuple[Port, ...]
    variability: str
    sampled: bool
    flags: tuple[int, str]
    code: tuple[str, str]
    binding: str


def interface(step: ExportedStep) -> Interface:
    """That of a model's step."""
    n, inputs = step.name, list[Port]()
    for i, (name, unit) in enumerate(zip(step.inputs, step.units, strict=True)):
        covered = ranges(step, i)
        start = min(max(0.0, covered[0]), covered[1]) if covered else 0.0
        inputs.append(Port(name, unit, covered, start))
    low, high = step.limits
    effort = Port("effort", step.model.units.effort or "1", (min(low, 0.0), max(high, 0.0)))
    text = "1: the network on the law's residual adds to the effort; 0: the effort is the law's alone"
    residual = () if step.model.correction is None else (Port("residual", "1", None, 1.0, text),)
    binding = f"""#define erc_reset {n}_reset
#define erc_step {n}_step
#define erc_use(state, parameter) {f"{n}_use_residual(state, (parameter)[0] != 0.0)" if residual else "((void)(state))"}
typedef {n}_state erc_state;
typedef {n}_real erc_real;
"""
    code = (source(step), header(step))
    return Interface(tuple(inputs), (effort,), residual, "tunable", has_memory(step), (31, flags_text()), code, binding)


def description(
    step: ExportedStep, face: Interface, version: int, identifier: str, token: str, files: list[str]
) -> Element:
    """The tree of modelDescription.xml.

    Args:
        step: what is exported.
        face: its variables.
        version: of FMI, 2 or 3.
        identifier: the modelIdentifier.
        token: GUID or instantiation token.
        files: sources to compile.
    """
    about = {
        "modelName": step.model.name,
        "description": f"{step.model.title}, model {step.digest}",
        "version": step.digest[:12],
        "generationTool": f"erclutch {__version__}",
        "variableNamingConvention": "flat",
        "fmiVersion": f"{version}.0",
        "guid" if version == 2 else "instantiationToken": token,
    }
    root = Element("fmiModelDescription", about)
    if version == 2:
        _interface2(root, identifier, files)
    else:
        _interfaces3(root, identifier, step, face)
    ports = (*face.inputs, *face.outputs, *face.parameters)
    units = sorted({port.unit for port in ports if _unit_of(port.unit)})
    if units:
        SubElement(root, "UnitDefinitions").extend(_unit_element(unit) for unit in units)
    SubElement(SubElement(root, "LogCategories"), "Category", {"name": "logStatusError"})
    if step.period is not None:
        SubElement(root, "DefaultExperiment", {"stepSize": repr(float(step.period))})
    _variables(face, version, SubElement(root, "ModelVariables"))
    _structure(face, version, SubElement(root, "ModelStructure"))
    return root


def _interface2(root: Element, identifier: str, files: list[str]) -> None:
    can = (
        "canHandleVariableCommunicationStepSize",
        "canNotUseMemoryManagementFunctions",
        "canGetAndSetFMUstate",
        "canSerializeFMUstate",
    )
    simulation = SubElement(root, "CoSimulation", {"modelIdentifier": identifier, **dict.fromkeys(can, "true")})
    SubElement(simulation, "SourceFiles").extend(Element("File", {"name": name}) for name in files)


def _interfaces3(root: Element, identifier: str, step: ExportedStep, face: Interface) -> None:
    common = {"modelIdentifier": identifier, "canGetAndSetFMUState": "true", "canSerializeFMUState": "true"}
    SubElement(root, "ModelExchange", common)
    simulation = {**common, "canHandleVariableCommunicationStepSize": "true"}
    if face.sampled and step.period is not None:
        simulation["fixedInternalStepSize"] = repr(float(step.period))
    SubElement(root, "CoSimulation", simulation)


def _variables(face: Interface, version: int, group: Element) -> None:
    if version == 3:
        time = {"name": "time", "valueReference": "0", "causality": "independent", "variability": "continuous"}
        SubElement(group, "Float64", time)
    for whole, entry, values in _signals(face):
        if version == 2:
            variable = SubElement(group, "ScalarVariable", entry)
            SubElement(variable, "Integer" if whole else "Real", values)
        else:
            SubElement(group, "UInt32" if whole else "Float64", {**entry, **values})


def _signals(face: Interface) -> Iterator[tuple[bool, dict[str, str], dict[str, str]]]:
    """All variables: whether each is a whole number, what it is, and its unit and limits."""
    discrete = "discrete" if face.sampled else "continuous"
    output = {"causality": "output", "initial": "calculated"}
    kinds = (
        [(port, {"causality": "input", "variability": "continuous"}) for port in face.inputs],
        [(port, {**output, "variability": discrete}) for port in face.outputs],
        [(None, {**output, "variability": "discrete"})],
        [(port, {"causality": "parameter", "variability": face.variability}) for port in face.parameters],
    )
    for reference, (port, kind) in enumerate((entry for entries in kinds for entry in entries), start=1):
        if port is None:
            most, text = face.flags
            entry = {"name": "flags", "valueReference": str(reference), **kind, "description": text}
            yield True, entry, {"min": "0", "max": str(most)}
            continue
        entry = {"name": port.name, "valueReference": str(reference), **kind}
        values = {**_unit_of(port.unit), **_limits(port.limits)}
        if kind["causality"] != "output":
            values["start"] = repr(float(port.start))
        yield False, {**entry, **({"description": port.meaning} if port.meaning else {})}, values


def _limits(covered: tuple[float, float] | None) -> dict[str, str]:
    return {} if covered is None else {"min": repr(float(covered[0])), "max": repr(float(covered[1]))}


def _structure(face: Interface, version: int, structure: Element) -> None:
    count = len(face.inputs)
    every = " ".join(str(i + 1) for i in range(count))
    for tag in ("Output", "InitialUnknown"):
        # In model exchange a sampled output changes at an event, with the inputs of that event.
        on = "" if version == 2 and tag == "Output" and face.sampled else every
        group = SubElement(structure, f"{tag}s") if version == 2 else structure
        for reference in (str(count + 1 + i) for i in range(len(face.outputs) + 1)):
            if version == 2:
                SubElement(group, "Unknown", {"index": reference, "dependencies": on})
            else:
                SubElement(group, tag, {"valueReference": reference, "dependencies": on})


def build_description(identifier: str, files: list[str]) -> Element:
    """The tree of FMI 3.0's buildDescription.xml."""
    root = Element("fmiBuildDescription", {"fmiVersion": "3.0"})
    configuration = SubElement(root, "BuildConfiguration", {"modelIdentifier": identifier})
    sources = SubElement(configuration, "SourceFileSet", {"language": "C99", "compilerOptions": "-ffp-contract=off"})
    sources.extend(Element("SourceFile", {"name": name}) for name in files)
    return root


def ranges(step: ExportedStep, i: int) -> tuple[float, float] | None:
    """Training range of an input, None for an angle; of a coaxial pair the speeds whose slips can stay in theirs."""
    e = step.elements
    if i < e:
        return step.field.range
    if i >= 2 * e:
        return step.extras[i - 2 * e].range
    if step.filter:
        return None
    low, high = step.slip.range
    if e == 1:
        return low, high
    # w1 = theta' - alpha' and w2 = -theta' - alpha' within [low, high].
    half = 0.5 * (high - low)
    return (-half, half) if i == 2 else (-high, -low)


def flags_text() -> str:
    """What the bits of flags mean."""
    return "; ".join(f"{1 << i}: {text}" for i, text in enumerate(FLAGS.values()) if i < 4)


def _unit_of(unit: str) -> dict[str, str]:
    """The attribute of a variable, where its unit can be told to a simulator."""
    return {} if unit in ("?", "1", "-", "") else {"unit": unit}


def _unit_element(text: str) -> Element:
    """A unit with its exponents of the SI's base units."""
    from erclutch.signals.units import parse

    made = Element("Unit", {"name": text})
    try:
        unit = parse(text)
    except ErclutchError:
        return made
    base: dict[str, str] = {}
    factor = unit.factor
    for name, exponent in unit.dimension:
        if name == "gram":
            name, factor = "kilogram", factor / 1000.0**exponent
        short = "rad" if name == "radian" else _BASE.get(name)
        if short is None or exponent != int(exponent):
            return made
        base[short] = str(int(exponent))
    SubElement(made, "BaseUnit", {**base, "factor": repr(float(factor))})
    return made
