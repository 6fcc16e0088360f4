"""Text files as a bad disk or a hasty editor leaves them."""

from __future__ import annotations

import numpy as np


def damaged(whole: bytes, rng: np.random.Generator) -> bytes:
    """Other bytes, or a part cut out, written twice, or moved."""
    text = bytearray(whole)
    for _ in range(int(rng.integers(1, 4))):
        start, length = int(rng.integers(len(text) or 1)), int(rng.integers(1, 20))
        kind = rng.integers(4)
        if kind == 0 and text:
            text[start] = int(rng.integers(256))
        elif kind == 1:
            del text[start : start + length]
        elif kind == 2:
            text[start:start] = text[start : start + length]
        else:
            text[start:start] = rng.choice(
                [b"nan", b"-1", b"1e999", b"{}", b"[[", b'"', b"0x10", b"\x00", b"= true"]
            )
    return bytes(text)
