"""Memory that a fit gives back is soon asked for again, so the C library is taught to keep it.

A fit makes and drops some hundred arrays of all rows in each step. Where each of them comes fresh from the system, a
third of the time goes into its pages. After a block of this size was freed once, glibc keeps freed memory up to twice
the size (mallopt(3), M_MMAP_THRESHOLD). Elsewhere nothing changes.
"""

from __future__ import annotations

import numpy as np

_BYTES = 31 << 20  # glibc learns from blocks below 32 MiB


def keep_heap() -> None:
    """Free a large block, never written to, once."""
    np.empty(_BYTES, np.uint8)
