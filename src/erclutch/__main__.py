"""``python -m erclutch`` and the command ``erclutch`` run the command line."""

import sys


def main() -> int:
    """Run the command of this process; an interrupt while its modules are imported is told as one that comes later.

    Returns:
        The exit code; see `erclutch.cli.main`.
    """
    try:
        from erclutch.cli import main as run

        return run()
    except KeyboardInterrupt:
        sys.stderr.write("error: interrupted; nothing was left half-written\n")
        return 130


if __name__ == "__main__":
    sys.exit(main())
