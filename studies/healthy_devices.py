"""Whether a healthy device trips: rigs drawn at random, each with its own model, filters, observers, motors. TWIN.

    python studies/healthy_devices.py [--devices 20] [--first 0]

`tests/support/healthy_devices.py` says what is drawn. Each device has sixteen sessions.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.healthy_devices import ROWS, healthy_sessions


def main() -> int:
    """Print each session that trips, and how many did; 1 if any did."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--devices", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="seed")
    asked = parser.parse_args()
    count = trips = 0
    for seed in range(asked.first, asked.first + asked.devices):
        for session in healthy_sessions(seed):
            count += 1
            if session.trip >= 0:
                trips += 1
                print(
                    f"{session.words}: trip in row {session.trip}: {' '.join(session.said)}",
                    flush=True,
                )
    print(
        f"TWIN: {trips} of {count} sessions of {ROWS} rows on {asked.devices} healthy devices trip"
    )
    return 1 if trips else 0


if __name__ == "__main__":
    raise SystemExit(main())
