"""What came out of the fits of a fleet: rows, numbers over the devices, and how a notebook shows them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from erclutch.signals.shown import Shown, one_line
from erclutch.wings.fleet.fleet_statistics import FleetSeries
from erclutch.wings.fleet.fleet_tables import Rows

if TYPE_CHECKING:
    from erclutch.report.notebook import Card


@dataclass(frozen=True, repr=False)
class Fleet(Shown):
    """What came out.

    Attributes:
        folder: where it is kept.
        parameters, fits: rows of the tables.
        series: each number of each model over the devices.
        model: the model that is recommended most often.
        digest: SHA-256 of the rows of both tables, sorted.
        taken: devices that were done by an earlier start.
        over: what the devices are ordered by.
        origins: labels of the logs, such as TWIN; "" of one that was measured.
        warned: devices whose logs look like those of several, with how.
    """

    folder: Path
    parameters: Rows
    fits: Rows
    series: tuple[FleetSeries, ...]
    model: str | None
    digest: str
    taken: int
    over: str
    origins: tuple[str, ...]
    warned: Mapping[str, str]

    def __repr__(self) -> str:
        most = f"most often {self.model or 'no model'}"
        return one_line(
            self, self.folder.name, f"{self.devices} devices", f"{len(self.failed)} failed", most
        )

    def notebook_card(self) -> Card:
        """What a notebook shows: the fits of the model that is recommended most often, and who stands out."""
        from erclutch.report.notebook import Card, as_frame, badge_of_origins, rows_as_frame
        from erclutch.report.plots.plot_description import Plot, PlotTable
        from erclutch.wings.fleet.fleet_charts import fleet_panels, named

        series = self.stands_for
        outlying = sorted({device for one in series for device in one.outliers})
        sentences = [f"Stands out: {named(tuple(outlying))}."] if outlying else []
        sentences += [f"{device} failed: {why}" for device, why in list(self.failed.items())[:3]]
        header = (
            "device",
            "model",
            "parameters",
            "rmse",
            "rmse_low",
            "rmse_high",
            "effort_unit",
            "share",
        )
        fits = [row for row in self.fits if row["model"] == self.model and not row["failed"]]
        columns = dict.fromkeys(key for row in self.parameters for key in row)

        def charts() -> Plot:
            panels = fleet_panels(series, self.over)
            return Plot(panels, PlotTable((), ()), 0.5 + 1.4 * len(panels))

        return Card(
            self.folder.name,
            lambda: rows_as_frame(header, [[row.get(key) for key in header] for row in fits]),
            badge=badge_of_origins(self.origins),
            says=lambda: sentences,
            frame=lambda: as_frame(
                {key: [row.get(key) for row in self.parameters] for key in columns}
            ),
            plots={"charts": charts},
        )

    @property
    def stands_for(self) -> tuple[FleetSeries, ...]:
        """Numbers of the model that stands for the fleet."""
        return tuple(series for series in self.series if series.model == self.model)

    @property
    def failed(self) -> dict[str, str]:
        """Devices that were not fitted, with the reasons."""
        reasons = {row["device"]: str(row["failed"]) for row in self.fits if row["failed"]}
        return {device: why.removeprefix(f"{device}: ") for device, why in reasons.items()}

    @property
    def devices(self) -> int:
        """All devices, those that failed too."""
        return len({row["device"] for row in self.fits})
