"""``python -m erclutch``."""

import sys

from erclutch.cli import main

sys.exit(main())
