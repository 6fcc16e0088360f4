"""Both FMU targets share model.h, the page and the archive."""

from __future__ import annotations

import hashlib
import tempfile
import zipfile
from concurrent.futures import ThreadPoolExecutor
from importlib import resources
from pathlib import Path
from xml.etree import ElementTree

from erclutch._version import __version__
from erclutch.errors import printable
from erclutch.export.c.c_source import header, source
from erclutch.export.encode import markup
from erclutch.export.exported_step import ExportedStep
from erclutch.export.fmu.fmu_binaries import build_binaries
from erclutch.export.fmu.fmu_description import build_description, description, flags_text, ranges
from erclutch.export.step_record import has_memory

#: Which binaries are in the FMU, and which are not and why.
BINARIES = "binaries.txt"


def identifier(program: ExportedStep, version: int) -> str:
    """The modelIdentifier."""
    return f"{program.name}_fmi{version}"


def archive_path(program: ExportedStep, version: int, folder: Path) -> Path:
    """The FMU's place in an export."""
    return folder / f"{identifier(program, version)}.fmu"


def write_fmu(program: ExportedStep, folder: Path, version: int) -> None:
    """Compile for every machine that there is a compiler for, and pack.

    Raises:
        ExportError: no compiler for this machine, or it failed.
    """
    with tempfile.TemporaryDirectory() as work, ThreadPoolExecutor(1) as pool:
        root, name = Path(work), identifier(program, version)
        code = root / "sources"
        code.mkdir()
        _sources(program, version, code)
        files = [f"fmi{version}.c", f"{program.name}.c"]
        # The description is written while the compilers run: to load the units takes half a second.
        lines = pool.submit(build_binaries, version, [code / file for file in files], name, root / "binaries")
        (root / "documentation").mkdir()
        (root / "documentation" / "index.html").write_text(_page(program), encoding="utf-8")
        _tree(description(program, version, name, token(program), files), root / "modelDescription.xml")
        if version == 3:
            _tree(build_description(name, files), code / "buildDescription.xml")
        (folder / BINARIES).write_text("".join(f"{line}\n" for line in lines.result()), encoding="utf-8")
        _pack(root, archive_path(program, version, folder))


def _sources(program: ExportedStep, version: int, folder: Path) -> None:
    texts = {f"{program.name}.c": source(program), f"{program.name}.h": header(program)}
    for name in ("core.h", "fmi_common.h", f"fmi{version}.h", f"fmi{version}.c"):
        texts[name] = resources.files("erclutch.export").joinpath(f"fmu/fmu_c/{name}").read_text(encoding="ascii")
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
#define ERC_RESIDUAL {int(program.model.correction is not None)} /* 1: a network on the residual can be switched off */
#define erc_use_residual {n}_use_residual
typedef {n}_state erc_state;
typedef {n}_real erc_real;

#endif
"""
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="ascii")


def token(program: ExportedStep) -> str:
    """GUID or instantiation token: changes with the exported C."""
    found = hashlib.sha256(source(program).encode()).hexdigest()
    return f"{{{found[:8]}-{found[8:12]}-{found[12:16]}-{found[16:20]}-{found[20:32]}}}"


def _page(program: ExportedStep) -> str:
    rows: list[str] = []
    for i, (name, unit) in enumerate(zip(program.inputs, program.units, strict=True)):
        covered = ranges(program, i)
        text = "any" if covered is None else f"{covered[0]:.6g} .. {covered[1]:.6g}"
        rows.append(f"<tr><td>{markup(name)}</td><td>{markup(unit)}</td><td>{text}</td></tr>")
    low, high = program.limits
    when = (
        f"The model has memory: it is sampled every {program.period:.9g} s. In co-simulation a sample is taken at the "
        "end of each period with the inputs that held through it; in model exchange by a time event."
        if has_memory(program)
        else "The model has no memory: its outputs follow the inputs at once, in model exchange without a step of lag."
    )
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{markup(program.model.name)}</title></head><body>
<h1>{markup(program.model.title)}</h1>
<p>Model {program.digest}, written by erclutch {__version__}.</p>
<table><tr><th>input</th><th>unit</th><th>training range</th></tr>{"".join(rows)}</table>
<p>effort in {markup(program.model.units.effort or "1")}, limited to {low:.6g} .. {high:.6g}.</p>
<p>flags, by bits: {markup(flags_text())}.</p>
<p>{when}</p>
</body></html>
"""


def _tree(root: ElementTree.Element, path: Path) -> None:
    for element in root.iter():  # the library writes characters that no XML may hold
        element.attrib = {key: printable(value) for key, value in element.attrib.items()}
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def _pack(root: Path, out: Path) -> None:
    """The same bytes for the same content: names in order, one date."""
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(p for p in root.rglob("*") if p.is_file()):
            entry = zipfile.ZipInfo(path.relative_to(root).as_posix(), (1980, 1, 1, 0, 0, 0))
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, path.read_bytes())
