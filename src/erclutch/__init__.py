"""erclutch turns a test-bench log of a field-controlled fluid clutch, brake or damper into a checked torque model.

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
from erclutch.signals.shown import Presenter, present_by

if TYPE_CHECKING:
    from erclutch.errors import ErclutchError
    from erclutch.export import export_model, verify_export
    from erclutch.fit.comparison import Comparison, Settings, compare
    from erclutch.fit.laws.fit_law import FitOutcome, fit_structure
    from erclutch.fit.networks.fit_network import fit_network
    from erclutch.fit.recalibration import Recalibration, recalibrate
    from erclutch.logs import ColumnMap, read, read_table, recording_from_arrays
    from erclutch.logs.dataset import Dataset, build_dataset
    from erclutch.logs.held_out import hold_out
    from erclutch.models.law_model import TorqueModel
    from erclutch.models.laws import law_from_name
    from erclutch.models.load import load_model
    from erclutch.models.networks import NetworkStructure, network_from_name
    from erclutch.models.networks.network_model import NetworkModel
    from erclutch.models.structure import Structure
    from erclutch.runs.new_rows import predict, score
    from erclutch.runs.run_folder import read_run
    from erclutch.runs.written_run import write_run
    from erclutch.signals.recording import Recording
    from erclutch.signals.speed import Derivative
    from erclutch.wings.align.aligned_logs import align
    from erclutch.wings.fleet.fitted_fleet import Fleet
    from erclutch.wings.fleet.fleet import fit_many
    from erclutch.wings.rheology.flow_curve import FlowCurve, fit_flow_curve


def _notebook() -> Presenter:
    """What shows values in a notebook. It stands above all values, so it is handed down to them."""
    from erclutch.report import notebook

    return notebook


present_by(_notebook)

_HOMES = {
    "fit.comparison": ("Comparison", "Settings", "compare"),
    "logs.dataset": ("Dataset", "build_dataset"),
    "logs.held_out": ("hold_out",),
    "signals.speed": ("Derivative",),
    "errors": ("ErclutchError",),
    "export": ("export_model", "verify_export"),
    "fit.recalibration": ("Recalibration", "recalibrate"),
    "runs.new_rows": ("predict", "score"),
    "fit.laws.fit_law": ("FitOutcome", "fit_structure"),
    "wings.rheology.flow_curve": ("FlowCurve", "fit_flow_curve"),
    "wings.fleet.fitted_fleet": ("Fleet",),
    "wings.fleet.fleet": ("fit_many",),
    "models.laws": ("law_from_name",),
    "logs": ("ColumnMap", "read", "read_table", "recording_from_arrays"),
    "wings.align.aligned_logs": ("align",),
    "models.law_model": ("TorqueModel",),
    "models.structure": ("Structure",),
    "models.networks": ("NetworkStructure", "network_from_name"),
    "models.networks.network_model": ("NetworkModel",),
    "fit.networks.fit_network": ("fit_network",),
    "runs.run_folder": ("read_run",),
    "runs.written_run": ("write_run",),
    "models.load": ("load_model",),
    "signals.recording": ("Recording",),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "ColumnMap",
    "Comparison",
    "Dataset",
    "Derivative",
    "ErclutchError",
    "FitOutcome",
    "Fleet",
    "FlowCurve",
    "NetworkModel",
    "NetworkStructure",
    "Recalibration",
    "Recording",
    "Settings",
    "Structure",
    "TorqueModel",
    "__version__",
    "align",
    "build_dataset",
    "compare",
    "export_model",
    "fit_flow_curve",
    "fit_many",
    "fit_network",
    "fit_structure",
    "hold_out",
    "law_from_name",
    "load_model",
    "network_from_name",
    "predict",
    "read",
    "read_run",
    "read_table",
    "recalibrate",
    "recording_from_arrays",
    "score",
    "verify_export",
    "write_run",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'erclutch' has no attribute {name!r}")
    try:
        home = importlib.import_module(f"erclutch.{_HOME_OF[name]}")
    except ModuleNotFoundError as error:
        from erclutch.errors import PluginError
        from erclutch.foreign_code import missing_wing

        told = missing_wing(error, f"erclutch.{name}")
        raise (PluginError(told[0], remedy=told[1]) if told else error) from None
    value = getattr(home, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
