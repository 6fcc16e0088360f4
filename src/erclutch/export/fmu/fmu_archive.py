"""What both FMU targets share: model.h, units, the archive."""

from __future__ import annotations

import re
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from importlib import resources
from pathlib import Path
from xml.etree import ElementTree

from erclutch._version import __version__
from erclutch.errors import ErclutchError
from erclutch.export.c_source import FLAGS, header, source
from erclutch.export.fmu_binaries import build_binaries
from erclutch.export.program import Program
from erclutch.export.step_record import has_memory

_BASE = {"kilogram": "kg", "meter": "m", "second": "s", "ampere": "A", "kelvin": "K", "mole": "mol", "candela": "cd"}
#: Which binaries are in the FMU, and which are not and why.
BINARIES = "binaries.txt"


def identifier(program: Program, version: int) -> str:
    """The modelIdentifier."""
    return f"{program.name}_fmi{version}"


def archive_path(program: Program, version: int, folder: Path) -> Path:
    """The FMU's place in an export."""
    return folder / f"{identifier(program, version)}.fmu"


def write_fmu(
    program: Program,
    folder: Path,
    version: int,
    description: Callable[[Program], ElementTree.Element],
    build: Callable[[Program], ElementTree.Element] | None = None,
) -> None:
    """Compile for every machine that there is a compiler for, and pack.

    Raises:
        ExportError: no compiler for this machine, or it failed.
    """
    with tempfile.TemporaryDirectory() as work, ThreadPoolExecutor(1) as pool:
        root = Path(work)
        code = root / "sources"
        code.mkdir()
        _sources(program, version, code)
        files = [code / name for name in source_files(program, version)]
        # The description is written while the compilers run: to load the units takes half a second.
        lines = pool.submit(build_binaries, version, files, identifier(program, version), root / "binaries")
        (root / "documentation").mkdir()
        (root / "documentation" / "index.html").write_text(_page(program), encoding="utf-8")
        _tree(description(program), root / "modelDescription.xml")
        if build is not None:
            _tree(build(program), code / "buildDescription.xml")
        (folder / BINARIES).write_text("".join(f"{line}\n" for line in lines.result()), encoding="utf-8")
        _pack(root, archive_path(program, version, folder))


def _sources(program: Program, version: int, folder: Path) -> None:
    texts = {f"{program.name}.c": source(program), f"{program.name}.h": header(program)}
    for name in ("core.h", f"fmi{version}.h", f"fmi{version}.c"):
        texts[name] = resources.files("erclutch.export").joinpath(f"fmu_c/{name}").read_text(encoding="ascii")
    n, period = program.name, program.period if has_memory(program) and program.period else 1.0
    texts["model.h"] = f"""/* Binds the FMU's code to {n}. */
#ifndef ERC_MODEL_H
#define ERC_MODEL_H

#include "{n}.h"

#define ERC_TOKEN "{token(program)}"
#define ERC_INPUTS {n.upper()}_INPUTS
#define ERC_SAMPLED {int(has_memory(program))} /* 1: has memory, so it is sampled */
#define ERC_PERIOD {period!r}
#define erc_reset {n}_reset
#define erc_step {n}_step
typedef {n}_state erc_state;
typedef {n}_real erc_real;

#endif
"""
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="ascii", errors="replace")


def token(program: Program) -> str:
    """GUID or instantiation token: changes with the exported C."""
    import hashlib

    found = hashlib.sha256(source(program).encode()).hexdigest()
    return f"{{{found[:8]}-{found[8:12]}-{found[12:16]}-{found[16:20]}-{found[20:32]}}}"


def source_files(program: Program, version: int) -> list[str]:
    """What is to be compiled."""
    return [f"fmi{version}.c", f"{program.name}.c"]


# --- model description -----------------------------------------------------------------------------------------------


def describe(program: Program, attributes: Mapping[str, str]) -> ElementTree.Element:
    """The root of modelDescription.xml."""
    return ElementTree.Element(
        "fmiModelDescription",
        {
            "modelName": program.model.name,
            "description": f"{program.model.title}, model {program.digest}",
            "version": program.digest[:12],
            "generationTool": f"erclutch {__version__}",
            "variableNamingConvention": "flat",
            **attributes,
        },
    )


def ranges(program: Program, i: int) -> tuple[float, float] | None:
    """Training range of an input, None for an angle; of a coaxial pair the speeds whose slips can stay in theirs."""
    e = program.elements
    if i < e:
        return program.field.range
    if i >= 2 * e:
        return program.extras[i - 2 * e].range
    if program.filter:
        return None
    low, high = program.slip.range
    if e == 1:
        return low, high
    # w1 = theta' - alpha' and w2 = -theta' - alpha' within [low, high].
    half = 0.5 * (high - low)
    return (-half, half) if i == 2 else (-high, -low)


def flags_text() -> str:
    """What the bits of flags mean."""
    return "; ".join(f"{1 << i}: {text}" for i, text in enumerate(FLAGS.values()) if i < 4)


def units(program: Program) -> list[str]:
    """Units that can be told to a simulator."""
    wanted = [*program.units, program.model.units.effort or "1"]
    return sorted({u for u in wanted if u not in ("?", "1", "-", "")})


def unit_element(text: str) -> ElementTree.Element:
    """A unit with its exponents of the SI's base units."""
    from erclutch.units import parse

    made = ElementTree.Element("Unit", {"name": text})
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
    ElementTree.SubElement(made, "BaseUnit", {**base, "factor": repr(float(factor))})
    return made


def unit_of(unit: str) -> dict[str, str]:
    """The attribute of a variable, where its unit is known."""
    return {} if unit in ("?", "1", "-", "") else {"unit": unit}


def number(value: float) -> str:
    """A number for XML."""
    return repr(float(value))


def _page(program: Program) -> str:
    rows: list[str] = []
    for i, (name, unit) in enumerate(zip(program.inputs, program.units, strict=True)):
        covered = ranges(program, i)
        text = "any" if covered is None else f"{covered[0]:.6g} .. {covered[1]:.6g}"
        rows.append(f"<tr><td>{_safe(name)}</td><td>{_safe(unit)}</td><td>{text}</td></tr>")
    low, high = program.limits
    when = (
        f"The model has memory: it is sampled every {program.period:.9g} s. In co-simulation a sample is taken at the "
        "end of each period with the inputs that held through it; in model exchange by a time event."
        if has_memory(program)
        else "The model has no memory: its outputs follow the inputs at once, in model exchange without a step of lag."
    )
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{_safe(program.model.name)}</title></head><body>
<h1>{_safe(program.model.title)}</h1>
<p>Model {program.digest}, written by erclutch {__version__}.</p>
<table><tr><th>input</th><th>unit</th><th>training range</th></tr>{"".join(rows)}</table>
<p>effort in {_safe(program.model.units.effort or "1")}, limited to {low:.6g} .. {high:.6g}.</p>
<p>flags, by bits: {_safe(flags_text())}.</p>
<p>{when}</p>
</body></html>
"""


def _safe(text: str) -> str:
    return re.sub("[<>&]", lambda m: f"&#{ord(m[0])};", text)


# --- archive ---------------------------------------------------------------------------------------------------------


def _tree(root: ElementTree.Element, path: Path) -> None:
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def _pack(root: Path, out: Path) -> None:
    """The same bytes for the same content: names in order, one date."""
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(p for p in root.rglob("*") if p.is_file()):
            entry = zipfile.ZipInfo(path.relative_to(root).as_posix(), (1980, 1, 1, 0, 0, 0))
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, path.read_bytes())
