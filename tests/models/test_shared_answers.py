"""A model that is asked for lone rows again and again answers by machine code, with the bits of the long road."""

from __future__ import annotations
