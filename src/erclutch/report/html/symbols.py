"""A page shows symbols, and data may stand inside a page."""

from __future__ import annotations

import contextlib
import unicodedata

from markupsafe import Markup


def _letter(name: str) -> str:
    """The Greek letter of that name, else the name."""
    with contextlib.suppress(KeyError):
        return unicodedata.lookup(f"GREEK SMALL LETTER {name.upper()}") if name.isascii() and len(name) > 1 else name
    return name


def symbol(name: str) -> Markup:
    """A parameter's name as a symbol: ``eta_0_1`` is an eta with the index 0,1."""
    head, *tail = name.split("_")
    letter = _letter(head)
    body = Markup("<span class=word>{}</span>" if len(letter) > 2 else "<i>{}</i>").format(letter)
    if not tail:
        return body
    return body + Markup("<sub>{}</sub>").format(", ".join(_letter(t) for t in tail))


def plain_symbol(name: str) -> str:
    """The same in plain text."""
    head, *tail = name.split("_")
    return _letter(head) + (f"_{','.join(tail)}" if tail else "")


def safe_json(text: str) -> Markup:
    """JSON that may stand inside a script element."""
    table = {ord("<"): "\\u003c", ord(">"): "\\u003e", ord("&"): "\\u0026", 0x2028: "\\u2028", 0x2029: "\\u2029"}
    return Markup(text.translate(table))
