"""``python -m erclutch`` runs the command line."""

import sys

from erclutch.cli import main

sys.exit(main())
