"""What `predict` costs with the exported C's own functions, beside NumPy's: `python benchmarks/predict.py`. TWIN rows.

Both in the same run on the same rows, in turn; least of some rounds, and the ratio.
"""

from __future__ import annotations

import argparse
from time import process_time
from typing import Any

from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.networks.fit_network import fit_network
from erclutch.models.laws import law_from_name
from erclutch.models.networks import is_network, network_from_name
from erclutch.models.structure import Structure
from erclutch.wings.paper.tables import twin_runs

NAMES = ("bingham", "hem", "seo-seo", "rbfm-10", "rbfn-50", "fnn-16", "fnn-10-6")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="CPU time of predictions, on the digital TWIN.")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--rounds", type=int, default=5)
    asked = parser.parse_args()
    (data,) = twin_runs(("training",), seconds=asked.seconds).values()
    print(f"TWIN, {data.rows:,} rows; CPU ms, least of {asked.rounds}")
    print(f"{'model':10}{'predict':>10}{'NumPy':>10}{'ratio':>8}")
    for name in NAMES:
        if is_network(name):
            model: Any = fit_network(data, network_from_name(name)).model
        else:
            model = fit_structure(
                data, Structure("coaxial", name, law_from_name(name, "coaxial"))
            ).model
        times: dict[bool, float] = {True: float("inf"), False: float("inf")}
        for _ in range(asked.rounds):
            for exactly in times:
                began = process_time()
                model.effort(data.elements, data.clock, exactly=exactly)
                times[exactly] = min(times[exactly], process_time() - began)
        print(
            f"{name:10}{1e3 * times[True]:10.1f}{1e3 * times[False]:10.1f}{times[True] / times[False]:8.2f}"
        )


if __name__ == "__main__":
    main()
