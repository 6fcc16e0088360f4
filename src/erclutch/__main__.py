"""``python -m erclutch`` and the command ``erclutch`` run the command line."""

import os
import sys

#: Matrices are small here: more threads of BLAS would wait for each other, and take CPU time from all else meanwhile.
_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def main() -> int:
    """Run the command of this process; an interrupt while its modules are imported is told as one that comes later.

    Returns:
        The exit code; see `erclutch.cli.main`.
    """
    for pool in _ONE_THREAD:
        os.environ.setdefault(pool, "1")  # before NumPy is imported, which makes its threads then
    try:
        from erclutch.cli import main as run

        return run()
    except KeyboardInterrupt:
        sys.stderr.write("error: interrupted; nothing was left half-written\n")
        eval(
            "None"
        )  # see `erclutch.cli.ending_signal.forget_interrupt`, which may not be there yet
        return 130


if __name__ == "__main__":
    sys.exit(main())
