"""This module writes the modelDescription.xml of FMI 2.0 and FMI 3.0: what both say, and how each of them says it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from xml.etree.ElementTree import Element, SubElement

from erclutch._version import __version__
from erclutch.errors import ErclutchError
from erclutch.export.c.c_header import header
from erclutch.export.c.c_source import FLAGS, source
from erclutch.export.exported_step import ExportedStep
from erclutch.export.step_record import has_memory

_BASE = {
    "kilogram": "kg",
    "meter": "m",
    "second": "s",
    "ampere": "A",
    "kelvin": "K",
    "mole": "mol",
    "candela": "cd",
}


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
    n = step.name
    inputs: list[Port] = []
    for i, (name, unit) in enumerate(zip(step.inputs, step.units, strict=True)):
        covered = ranges(step, i)
        start = 0.0
        if covered is not None:  # zero, or what is nearest to it
            low, high = covered
            start = min(max(0.0, low), high)
        inputs.append(Port(name, unit, covered, start))

    low, high = step.limits
    effort = Port("effort", step.model.units.effort or "1", (min(low, 0.0), max(high, 0.0)))
    parameters: tuple[Port, ...] = ()
    use = "((void)(state))"
    if step.model.correction is not None:
        meaning = "1: the network on the law's residual adds to the effort; 0: the effort is the law's alone"
        parameters = (Port("residual", "1", None, 1.0, meaning),)
        use = f"{n}_use_residual(state, (parameter)[0] != 0.0)"
    binding = f"""#define erc_reset {n}_reset
#define erc_step {n}_step
#define erc_use(state, parameter) {use}
typedef {n}_state erc_state;
typedef {n}_real erc_real;
"""
    return Interface(
        inputs=tuple(inputs),
        outputs=(effort,),
        parameters=parameters,
        variability="tunable",
        sampled=has_memory(step),
        flags=(31, flags_text()),
        code=(source(step), header(step)),
        binding=binding,
    )


def description(
    step: ExportedStep,
    face: Interface,
    version: int,
    identifier: str,
    token: str,
    files: list[str],
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

    # What it can do, for each kind of simulation.
    if version == 2:
        can = (
            "canHandleVariableCommunicationStepSize",
            "canNotUseMemoryManagementFunctions",
            "canGetAndSetFMUstate",
            "canSerializeFMUstate",
        )
        simulation = SubElement(
            root, "CoSimulation", {"modelIdentifier": identifier, **dict.fromkeys(can, "true")}
        )
        SubElement(simulation, "SourceFiles").extend(
            Element("File", {"name": name}) for name in files
        )
    else:
        common = {
            "modelIdentifier": identifier,
            "canGetAndSetFMUState": "true",
            "canSerializeFMUState": "true",
        }
        SubElement(root, "ModelExchange", common)
        own = {**common, "canHandleVariableCommunicationStepSize": "true"}
        if face.sampled and step.period is not None:
            own["fixedInternalStepSize"] = repr(float(step.period))
        SubElement(root, "CoSimulation", own)

    ports = (*face.inputs, *face.outputs, *face.parameters)
    units = sorted({port.unit for port in ports if _unit_of(port.unit)})
    if units:
        SubElement(root, "UnitDefinitions").extend(_unit_element(unit) for unit in units)
    SubElement(SubElement(root, "LogCategories"), "Category", {"name": "logStatusError"})
    if step.period is not None:
        SubElement(root, "DefaultExperiment", {"stepSize": repr(float(step.period))})

    variables = SubElement(root, "ModelVariables")
    if version == 3:
        time = {
            "name": "time",
            "valueReference": "0",
            "causality": "independent",
            "variability": "continuous",
        }
        SubElement(variables, "Float64", time)
    for whole, entry, values in _signals(face):
        if version == 2:
            variable = SubElement(variables, "ScalarVariable", entry)
            SubElement(variable, "Integer" if whole else "Real", values)
        else:
            SubElement(variables, "UInt32" if whole else "Float64", {**entry, **values})

    # What depends on what: outputs and flags on all inputs.
    structure = SubElement(root, "ModelStructure")
    inputs = len(face.inputs)
    every_input = " ".join(str(i + 1) for i in range(inputs))
    # Value references of the outputs; the last is that of the flags.
    results = [str(inputs + 1 + i) for i in range(len(face.outputs) + 1)]
    for tag in ("Output", "InitialUnknown"):
        # In model exchange a sampled output changes at an event, with the inputs of that event.
        on = "" if version == 2 and tag == "Output" and face.sampled else every_input
        group = SubElement(structure, f"{tag}s") if version == 2 else structure
        for reference in results:
            if version == 2:
                SubElement(group, "Unknown", {"index": reference, "dependencies": on})
            else:
                SubElement(group, tag, {"valueReference": reference, "dependencies": on})
    return root


def _signals(face: Interface) -> Iterator[tuple[bool, dict[str, str], dict[str, str]]]:
    """All variables: whether each is a whole number, what it is, and its unit and limits."""
    as_input = {"causality": "input", "variability": "continuous"}
    as_output = {
        "causality": "output",
        "initial": "calculated",
        "variability": "discrete" if face.sampled else "continuous",
    }
    as_parameter = {"causality": "parameter", "variability": face.variability}
    references = count(1)

    def of_port(port: Port, kind: dict[str, str]) -> tuple[bool, dict[str, str], dict[str, str]]:
        entry = {"name": port.name, "valueReference": str(next(references)), **kind}
        if port.meaning:
            entry["description"] = port.meaning
        values = _unit_of(port.unit)
        if port.limits is not None:
            low, high = port.limits
            values |= {"min": repr(float(low)), "max": repr(float(high))}
        if kind is not as_output:
            values["start"] = repr(float(port.start))
        return False, entry, values

    for port in face.inputs:
        yield of_port(port, as_input)
    for port in face.outputs:
        yield of_port(port, as_output)
    most, meaning = face.flags
    flags = {
        "name": "flags",
        "valueReference": str(next(references)),
        **as_output,
        "variability": "discrete",
    }
    yield True, {**flags, "description": meaning}, {"min": "0", "max": str(most)}
    for port in face.parameters:
        yield of_port(port, as_parameter)


def build_description(identifier: str, files: list[str]) -> Element:
    """The tree of FMI 3.0's buildDescription.xml."""
    root = Element("fmiBuildDescription", {"fmiVersion": "3.0"})
    configuration = SubElement(root, "BuildConfiguration", {"modelIdentifier": identifier})
    sources = SubElement(
        configuration, "SourceFileSet", {"language": "C99", "compilerOptions": "-ffp-contract=off"}
    )
    sources.extend(Element("SourceFile", {"name": name}) for name in files)
    return root


def ranges(step: ExportedStep, i: int) -> tuple[float, float] | None:
    """Training range of an input, None for an angle; of a coaxial pair the speeds whose slips can stay in theirs."""
    elements = step.elements
    if i < elements:
        return step.field.range
    if i >= 2 * elements:
        return step.extras[i - 2 * elements].range
    if step.filter:
        return None
    low, high = step.slip.range
    if elements == 1:
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

    element = Element("Unit", {"name": text})
    try:
        unit = parse(text)
    except ErclutchError:
        return element
    exponents: dict[str, str] = {}
    factor = unit.factor
    for name, exponent in unit.dimension:
        if name == "gram":  # FMI counts in kilograms
            name = "kilogram"
            factor = factor / 1000.0**exponent
        short = "rad" if name == "radian" else _BASE.get(name)
        if short is None or exponent != int(exponent):  # FMI cannot say it
            return element
        exponents[short] = str(int(exponent))
    SubElement(element, "BaseUnit", {**exponents, "factor": repr(float(factor))})
    return element
