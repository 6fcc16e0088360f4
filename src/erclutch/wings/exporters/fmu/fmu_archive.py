"""Both FMU targets share fmu-model.h, the page and the archive."""

from __future__ import annotations

import hashlib
import zipfile
from concurrent.futures import ThreadPoolExecutor
from importlib import resources
from pathlib import Path
from xml.etree import ElementTree

from erclutch._version import __version__
from erclutch.errors import printable
from erclutch.export.encode import markup
from erclutch.export.exported_step import ExportedStep
from erclutch.files import scratch_folder
from erclutch.wings.exporters.fmu.fmu_binaries import build_binaries
from erclutch.wings.exporters.fmu.fmu_description import (
    Interface,
    Port,
    build_description,
    description,
    interface,
)

#: Which binaries are in the FMU, and which are not and why.
BINARIES = "binaries.txt"


def identifier(step: ExportedStep, version: int) -> str:
    """The modelIdentifier."""
    return f"{step.name}_fmi{version}"


def archive_path(step: ExportedStep, version: int, folder: Path) -> Path:
    """The FMU's place in an export."""
    return folder / f"{identifier(step, version)}.fmu"


def write_fmu(
    step: ExportedStep,
    folder: Path,
    version: int,
    face: Interface | None = None,
) -> None:
    """Compile for every machine that there is a compiler for, and pack; by default the model's step alone.

    Raises:
        ExportError: no compiler for this machine, or it failed.
    """
    face = face or interface(step)
    name = identifier(step, version)
    files = [f"fmu-fmi{version}.c", f"{step.name}.c"]

    # The C of the model, that of the FMU, and fmu-model.h, which binds the two. A name of C has no hyphen.
    source, header = face.code
    texts = {f"{step.name}.c": source, f"{step.name}.h": header}
    sources = resources.files("erclutch.wings.exporters") / "fmu" / "fmu_c"
    for file in ("fmu-core.h", "fmu-common.h", f"fmu-fmi{version}.h", f"fmu-fmi{version}.c"):
        texts[file] = (sources / file).read_text(encoding="ascii")
    period = step.period if face.sampled and step.period else 1.0  # s
    # C wants a default at least.
    defaults = [*(repr(float(port.start)) for port in face.parameters), "0.0"]
    texts["fmu-model.h"] = f"""/* Binds the FMU's code to {step.name}. */
#ifndef ERC_FMU_MODEL_HEADER
#define ERC_FMU_MODEL_HEADER

#include "{step.name}.h"

#define ERC_TOKEN "{token(face)}"
#define ERC_INPUTS {len(face.inputs)}u
#define ERC_OUTPUTS {len(face.outputs)}u
#define ERC_PARAMETERS {len(face.parameters)}u
#define ERC_DEFAULTS {", ".join(defaults)}
#define ERC_SAMPLED {int(face.sampled)} /* 1: has memory, so it is sampled */
#define ERC_PERIOD {period!r}
{face.binding}
#endif
"""

    with scratch_folder() as work, ThreadPoolExecutor(1) as pool:
        root = Path(work)
        code = root / "sources"
        code.mkdir()
        for file, text in texts.items():
            (code / file).write_text(text, encoding="ascii")
        # The description is written while the compilers run: to load the units takes half a second.
        building = pool.submit(
            build_binaries, version, [code / file for file in files], name, root / "binaries"
        )
        pages = root / "documentation"
        pages.mkdir()
        (pages / "index.html").write_text(_page(step, face), encoding="utf-8")
        about = description(step, face, version, name, token(face), files)
        _tree(about, root / "modelDescription.xml")
        if version == 3:
            _tree(build_description(name, files), code / "buildDescription.xml")
        came_of_it = "".join(f"{line}\n" for line in building.result())
        (folder / BINARIES).write_text(came_of_it, encoding="utf-8")
        # The same bytes for the same content: names in order, one date.
        packed = archive_path(step, version, folder)
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
            for path in sorted(p for p in root.rglob("*") if p.is_file()):
                name = path.relative_to(root).as_posix()
                entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.external_attr = 0o644 << 16  # rights of a file, as Unix has them
                archive.writestr(entry, path.read_bytes())


def token(face: Interface) -> str:
    """GUID or instantiation token: changes with the exported C."""
    source, _ = face.code
    digest = hashlib.sha256(source.encode()).hexdigest()
    return f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"


def _page(step: ExportedStep, face: Interface) -> str:
    """The page about the FMU: its variables and when it is sampled."""

    def row(port: Port) -> str:
        covered = "any" if port.limits is None else "{:.6g} .. {:.6g}".format(*port.limits)
        return (
            f"<tr><td>{markup(port.name)}</td><td>{markup(port.unit)}</td><td>{covered}</td></tr>"
        )

    tables: list[str] = []
    for kind, ports in (
        ("input", face.inputs),
        ("output", face.outputs),
        ("parameter", face.parameters),
    ):
        if ports:
            rows = "".join(row(port) for port in ports)
            tables.append(
                f"<table><tr><th>{kind}</th><th>unit</th><th>range</th></tr>{rows}</table>"
            )
    if face.sampled:
        when = (
            f"The model has memory: it is sampled every {step.period:.9g} s. In co-simulation a sample is taken at the "
            "end of each period with the inputs that held through it; in model exchange by a time event."
        )
    else:
        when = (
            "The model has no memory: its outputs follow the inputs at once, in model exchange "
            "without a step of lag."
        )
    table_lines = "\n".join(tables)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{markup(step.model.name)}</title></head><body>
<h1>{markup(step.model.title)}</h1>
<p>Model {step.digest}, written by erclutch {__version__}.</p>
{table_lines}
<p>flags, by bits: {markup(face.flags[1])}.</p>
<p>{when}</p>
</body></html>
"""


def _tree(root: ElementTree.Element, path: Path) -> None:
    """Write XML; what no XML may hold is escaped in the attributes."""
    for element in root.iter():  # the library writes characters that no XML may hold
        element.attrib = {key: printable(value) for key, value in element.attrib.items()}
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)
