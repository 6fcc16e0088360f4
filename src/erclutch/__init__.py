"""erclutch: from a test-bench log of a field-controlled fluid clutch, brake or damper to a checked torque model.

The main job in Python::

    import erclutch

    log = erclutch.read("run1.csv", {"field": "Y [V]", "slip": "V [cm/s]", "effort": "F [N]"})
    result = erclutch.compare(erclutch.build_dataset(log))
    print(result.recommended)

Names are looked up when they are first used, so that importing the package costs nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from erclutch._version import __version__

if TYPE_CHECKING:
    from erclutch.comparison import Comparison, Settings, compare
    from erclutch.dataset import Dataset, build_dataset, hold_out
    from erclutch.differentiate import Derivative
    from erclutch.errors import ErclutchError
    from erclutch.evaluate import score
    from erclutch.fit import FitOutcome, fit_structure
    from erclutch.fit.networks import fit_network
    from erclutch.flowcurve import FlowCurve, fit_flow_curve
    from erclutch.large import LargeFit, fit_large
    from erclutch.laws import law_from_name
    from erclutch.logs import ColumnMap, read, read_table, recording_from_arrays
    from erclutch.model import Structure, TorqueModel
    from erclutch.networks import NetworkStructure, network_from_name
    from erclutch.networks.model import NetworkModel
    from erclutch.runs import read_run, write_run
    from erclutch.saved import load_model
    from erclutch.signals import Recording

_HOMES = {
    "comparison": ("Comparison", "Settings", "compare"),
    "dataset": ("Dataset", "build_dataset", "hold_out"),
    "differentiate": ("Derivative",),
    "errors": ("ErclutchError",),
    "evaluate": ("score",),
    "fit": ("FitOutcome", "fit_structure"),
    "flowcurve": ("FlowCurve", "fit_flow_curve"),
    "large": ("LargeFit", "fit_large"),
    "laws": ("law_from_name",),
    "logs": ("ColumnMap", "read", "read_table", "recording_from_arrays"),
    "model": ("Structure", "TorqueModel"),
    "networks": ("NetworkStructure", "network_from_name"),
    "networks.model": ("NetworkModel",),
    "fit.networks": ("fit_network",),
    "runs": ("read_run", "write_run"),
    "saved": ("load_model",),
    "signals": ("Recording",),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "ColumnMap",
    "Comparison",
    "Dataset",
    "Derivative",
    "ErclutchError",
    "FitOutcome",
    "FlowCurve",
    "LargeFit",
    "NetworkModel",
    "NetworkStructure",
    "Recording",
    "Settings",
    "Structure",
    "TorqueModel",
    "__version__",
    "build_dataset",
    "compare",
    "fit_flow_curve",
    "fit_large",
    "fit_network",
    "fit_structure",
    "hold_out",
    "law_from_name",
    "load_model",
    "network_from_name",
    "read",
    "read_run",
    "read_table",
    "recording_from_arrays",
    "score",
    "write_run",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'erclutch' has no attribute {name!r}")
    home = importlib.import_module(f"erclutch.{_HOME_OF[name]}")
    value = getattr(home, name)
    globals()[name] = value
    return value
