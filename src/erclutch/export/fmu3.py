"""Target fmu3: an FMU 3.0 for co-simulation and model exchange."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from erclutch.export import fmu
from erclutch.export.check import Check
from erclutch.export.program import Program
from erclutch.export.step_record import has_memory

TITLE = "an FMU 3.0 for co-simulation and model exchange, with its C sources"


def write(program: Program, folder: Path) -> None:
    """NAME_fmi3.fmu."""
    fmu.write_fmu(program, folder, 3, _description, _build)


def _build(program: Program) -> ElementTree.Element:
    root = ElementTree.Element("fmiBuildDescription", {"fmiVersion": "3.0"})
    configuration = ElementTree.SubElement(root, "BuildConfiguration", {"modelIdentifier": fmu.identifier(program, 3)})
    options = {"language": "C99", "compilerOptions": "-ffp-contract=off"}
    files = ElementTree.SubElement(configuration, "SourceFileSet", options)
    for name in fmu.source_files(program, 3):
        ElementTree.SubElement(files, "SourceFile", {"name": name})
    return root


def _description(program: Program) -> ElementTree.Element:
    root = fmu.describe(program, {"fmiVersion": "3.0", "instantiationToken": fmu.token(program)})
    common = {
        "modelIdentifier": fmu.identifier(program, 3),
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
    }
    ElementTree.SubElement(root, "ModelExchange", common)
    simulation = {**common, "canHandleVariableCommunicationStepSize": "true"}
    if has_memory(program) and program.period is not None:
        simulation["fixedInternalStepSize"] = fmu.number(program.period)
    ElementTree.SubElement(root, "CoSimulation", simulation)
    if fmu.units(program):
        definitions = ElementTree.SubElement(root, "UnitDefinitions")
        for unit in fmu.units(program):
            definitions.append(fmu.unit_element(unit))
    categories = ElementTree.SubElement(root, "LogCategories")
    ElementTree.SubElement(categories, "Category", {"name": "logStatusError"})
    if program.period is not None:
        ElementTree.SubElement(root, "DefaultExperiment", {"stepSize": fmu.number(program.period)})
    _variables(program, ElementTree.SubElement(root, "ModelVariables"))
    structure = ElementTree.SubElement(root, "ModelStructure")
    count = len(program.inputs)
    every = " ".join(str(i + 1) for i in range(count))
    # In model exchange a sampled output changes at an event, with the inputs of that event.
    for tag in ("Output", "InitialUnknown"):
        for reference in (count + 1, count + 2):
            ElementTree.SubElement(structure, tag, {"valueReference": str(reference), "dependencies": every})
    return root


def _variables(program: Program, group: ElementTree.Element) -> None:
    time = {"name": "time", "valueReference": "0", "causality": "independent", "variability": "continuous"}
    ElementTree.SubElement(group, "Float64", time)
    for i, (name, unit) in enumerate(zip(program.inputs, program.units, strict=True)):
        entry = {"name": name, "valueReference": str(i + 1), "causality": "input", "variability": "continuous"}
        covered = fmu.ranges(program, i)
        limits = {} if covered is None else {"min": fmu.number(covered[0]), "max": fmu.number(covered[1])}
        start = fmu.number(min(max(0.0, covered[0]), covered[1]) if covered else 0.0)
        ElementTree.SubElement(group, "Float64", {**entry, **fmu.unit_of(unit), **limits, "start": start})
    count = len(program.inputs)
    low, high = program.limits
    output = {"causality": "output", "initial": "calculated"}
    variability = "discrete" if has_memory(program) else "continuous"
    effort = {"name": "effort", "valueReference": str(count + 1), **output, "variability": variability}
    limits = {"min": fmu.number(min(low, 0.0)), "max": fmu.number(max(high, 0.0))}
    ElementTree.SubElement(group, "Float64", {**effort, **fmu.unit_of(program.model.units.effort or "1"), **limits})
    flags = {"name": "flags", "valueReference": str(count + 2), **output, "variability": "discrete"}
    ElementTree.SubElement(group, "UInt32", {**flags, "description": fmu.flags_text(), "min": "0", "max": "31"})


def verify(program: Program, folder: Path) -> Iterator[Check]:
    """Validate and simulate it with FMPy, both ways."""
    from erclutch.export.fmu_run import check_fmu

    yield from check_fmu(program, folder, 3, ("CoSimulation", "ModelExchange"))
