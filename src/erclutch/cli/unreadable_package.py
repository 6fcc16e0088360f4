"""A library may end in an error of its own because another package, which it looks at, cannot be read."""

from __future__ import annotations

from importlib.metadata import distributions

from erclutch.errors import PluginError


def unreadable_package() -> PluginError | None:
    """What to tell of an installed package whose list of plug-ins cannot be read; None where each can be read.

    Libraries such as Numba look through the lists of all packages, and take it as given that each is sound.
    """
    for package in distributions():
        try:
            for point in package.entry_points:
                str(point.value)
        except Exception:
            try:
                name = str(package.metadata["Name"] or "without a name")
            except Exception:
                name = "without a name"
            folder = package.locate_file("")
            problem = f"the package {name} in {folder} has a list of plug-ins that cannot be read"
            return PluginError(
                problem, remedy=f"Remove it, or install it again: pip uninstall {name}"
            )
    return None
