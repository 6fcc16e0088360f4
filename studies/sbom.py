"""The bill of materials of what erclutch runs on, as CycloneDX: every package that `requirements.lock` pins for it.

    make sbom        # writes sbom.cdx.json; installs the CycloneDX library beside the project, not into .venv

Packages, versions and who needs whom come from `requirements.lock`, which holds for all systems. Licences come from the
installed packages. Packages that only development needs are left out. The same lock gives the same file.
"""

# pyright: reportMissingImports=false

from __future__ import annotations

import hashlib
import json
import re
import sys
import tomllib
import uuid
from importlib import metadata
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parents[1]
LOCK = HERE / "requirements.lock"
OUT = HERE / "sbom.cdx.json"
VENDORED = HERE / "src/erclutch/report/assets/uplot/ORIGIN.toml"
#: Where `make sbom` puts the library. It stands behind .venv on the path, so that licences are those of .venv.
LIBRARY = HERE / "build" / "cyclonedx"


def normal(name: str) -> str:
    """A package's name as registries compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def declared(extras: bool) -> set[str]:
    """Names in `dependencies`, with or without those of the extras."""
    project = tomllib.loads((HERE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    more = project["optional-dependencies"].values() if extras else ()
    return {
        normal(re.split(r"[^\w.-]", line)[0])
        for lines in (project["dependencies"], *more)
        for line in lines
    }


def locked(text: str) -> tuple[dict[str, str], dict[str, set[str]]]:
    """Version of each pinned package, and the packages that need it."""
    versions, needed_by, name = dict[str, str](), dict[str, set[str]](), ""
    for line in text.splitlines():
        if pin := re.match(r"([\w.-]+)==([^\s;]+)", line):
            name = normal(pin[1])
            versions[name] = pin[2]
            needed_by[name] = set()
        elif by := re.match(r"    #(?: via|  ) (\S.*)", line):
            needed_by[name].add(by[1])
    return versions, needed_by


def closure(names: set[str], needed_by: dict[str, set[str]]) -> set[str]:
    """These packages and all that they need."""
    found, grown = set[str](), set(names)
    while grown:
        found |= grown
        grown = {name for name, by in needed_by.items() if by & found} - found
    return found


def licence(name: str) -> str:
    """The licence that an installed package states: SPDX where it uses SPDX, else its own words."""
    said: Any = metadata.metadata(name)
    classifiers = [
        c.rpartition(" :: ")[2]
        for c in said.get_all("Classifier", [])
        if c.startswith("License ::")
    ]
    stated = said.get("License-Expression") or ", ".join(classifiers) or said.get("License")
    if not stated:
        raise SystemExit(f"{name} states no licence: look it up and name it here")
    return str(stated)


def bill() -> str:
    """The whole document."""
    from cyclonedx.contrib.license.factories import LicenseFactory
    from cyclonedx.model.bom import Bom
    from cyclonedx.model.component import Component, ComponentScope, ComponentType
    from cyclonedx.output.json import JsonV1Dot6
    from packageurl import PackageURL

    text = LOCK.read_text(encoding="utf-8")
    versions, needed_by = locked(text)
    always, licences = closure(declared(extras=False), needed_by), LicenseFactory()

    def component(
        name: str, version: str, stated: str, kind: str, scope: ComponentScope | None
    ) -> Component:
        address = PackageURL(kind, None, name, version)
        return Component(
            name=name,
            version=version,
            type=ComponentType.LIBRARY,
            licenses=[licences.make_from_string(stated)],
            purl=address,
            bom_ref=address.to_string(),
            scope=scope,
        )

    project = tomllib.loads((HERE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    own = component("erclutch", metadata.version("erclutch"), project["license"], "pypi", None)
    optional, required = ComponentScope.OPTIONAL, ComponentScope.REQUIRED
    parts = {
        name: component(
            name, versions[name], licence(name), "pypi", required if name in always else optional
        )
        for name in sorted(closure(declared(extras=True), needed_by))
    }
    origin = tomllib.loads(VENDORED.read_text(encoding="utf-8"))
    vendored = component(
        origin["name"], origin["version"], origin["licence"], origin["source"], required
    )
    document = Bom(
        components=[*parts.values(), vendored],
        serial_number=uuid.uuid5(uuid.NAMESPACE_URL, hashlib.sha256(text.encode()).hexdigest()),
    )
    document.metadata.component = own
    document.register_dependency(
        own, [*(parts[name] for name in sorted(declared(extras=True))), vendored]
    )
    for name, part in parts.items():
        document.register_dependency(
            part, [other for key, other in parts.items() if name in needed_by[key]]
        )
    # The time of the run says nothing about the packages and would make each file another one.
    told = json.loads(JsonV1Dot6(document).output_as_string())
    del told["metadata"]["timestamp"]
    return json.dumps(told, indent=1) + "\n"


def check(text: str) -> None:
    """Hold the document to the schema of CycloneDX."""
    from cyclonedx.schema import SchemaVersion
    from cyclonedx.validation.json import JsonStrictValidator

    if fault := JsonStrictValidator(SchemaVersion.V1_6).validate_str(text):
        raise SystemExit(f"not valid CycloneDX 1.6: {fault}")


def main() -> None:
    """Write `sbom.cdx.json`."""
    if sys.argv[1:]:
        raise SystemExit(__doc__)
    sys.path.append(str(LIBRARY))
    text = bill()
    check(text)
    OUT.write_text(text, encoding="utf-8")
    packages = json.loads(text)["components"]
    print(f"{OUT.name}: {len(packages)} packages")


if __name__ == "__main__":
    main()
