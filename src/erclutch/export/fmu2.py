"""Target fmu2: an FMU 2.0 for co-simulation."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from erclutch.export import fmu
from erclutch.export.check import Check
from erclutch.export.program import Program
from erclutch.export.step_record import has_memory

TITLE = "an FMU 2.0 for co-simulation, with its C sources"


def write(program: Program, folder: Path) -> None:
    """NAME_fmi2.fmu."""
    fmu.write_fmu(program, folder, 2, _description)


def _description(program: Program) -> ElementTree.Element:
    attributes = {"fmiVersion": "2.0", "guid": fmu.token(program)}
    root = fmu.describe(program, attributes)
    simulation = ElementTree.SubElement(
        root,
        "CoSimulation",
        {
            "modelIdentifier": fmu.identifier(program, 2),
            "canHandleVariableCommunicationStepSize": "true",
            "canNotUseMemoryManagementFunctions": "true",
            "canGetAndSetFMUstate": "true",
            "canSerializeFMUstate": "true",
        },
    )
    files = ElementTree.SubElement(simulation, "SourceFiles")
    for name in fmu.source_files(program, 2):
        ElementTree.SubElement(files, "File", {"name": name})
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
    direct = "" if has_memory(program) else " ".join(str(i + 1) for i in range(count))
    for tag in ("Outputs", "InitialUnknowns"):
        group = ElementTree.SubElement(structure, tag)
        on = direct if tag == "Outputs" else " ".join(str(i + 1) for i in range(count))
        for index in (count + 1, count + 2):
            ElementTree.SubElement(group, "Unknown", {"index": str(index), "dependencies": on})
    return root


def _variables(program: Program, group: ElementTree.Element) -> None:
    for i, (name, unit) in enumerate(zip(program.inputs, program.units, strict=True)):
        entry = {"name": name, "valueReference": str(i + 1), "causality": "input", "variability": "continuous"}
        variable = ElementTree.SubElement(group, "ScalarVariable", entry)
        covered = fmu.ranges(program, i)
        limits = {} if covered is None else {"min": fmu.number(covered[0]), "max": fmu.number(covered[1])}
        start = fmu.number(min(max(0.0, covered[0]), covered[1]) if covered else 0.0)
        ElementTree.SubElement(variable, "Real", {"start": start, **limits, **fmu.unit_of(unit)})
    kind = {"causality": "output", "variability": "discrete" if has_memory(program) else "continuous"}
    count = len(program.inputs)
    effort = {"name": "effort", "valueReference": str(count + 1), **kind, "initial": "calculated"}
    low, high = program.limits
    limits = {"min": fmu.number(min(low, 0.0)), "max": fmu.number(max(high, 0.0))}
    variable = ElementTree.SubElement(group, "ScalarVariable", effort)
    ElementTree.SubElement(variable, "Real", {**limits, **fmu.unit_of(program.model.units.effort or "1")})
    flags = {"name": "flags", "valueReference": str(count + 2), "causality": "output", "variability": "discrete"}
    variable = ElementTree.SubElement(
        group, "ScalarVariable", {**flags, "initial": "calculated", "description": fmu.flags_text()}
    )
    ElementTree.SubElement(variable, "Integer", {"min": "0", "max": "31"})


def verify(program: Program, folder: Path) -> Iterator[Check]:
    """Validate and simulate it with FMPy."""
    from erclutch.export.fmu_run import check_fmu

    yield from check_fmu(program, folder, 2, ("CoSimulation",))
