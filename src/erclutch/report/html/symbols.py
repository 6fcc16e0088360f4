"""A page shows symbols, and data may stand inside a page."""

from __future__ import annotations

import contextlib
import re
import unicodedata

from markupsafe import Markup


def _letter(name: str) -> str:
    """The Greek letter of that name, else the name."""
    if len(name) > 1 and name.isascii():
        with contextlib.suppress(KeyError):
            return unicodedata.lookup(f"GREEK SMALL LETTER {name.upper()}")
    return name


def symbol(name: str) -> Markup:
    """A parameter's name as a symbol: ``eta_0_1`` is an eta with the index 0,1."""
    head, *tail = name.split("_")
    letter = _letter(head)
    body = Markup("<span class=word>{}</span>" if len(letter) > 2 else "<i>{}</i>").format(letter)
    if not tail:
        return body
    letters = ", ".join(_letter(t) for t in tail)
    return body + Markup("<sub>{}</sub>").format(letters)


def equation_text(text: str) -> Markup:
    """An equation in plain text with its names as symbols: those with an index, Greek ones, and single letters."""
    text = re.sub(r"\b(alpha|beta|zeta|tau)\b", lambda found: _letter(found[0]), text)
    with_signs = text.replace("'", "′").replace(" - ", " − ")
    text = re.sub(r"(?<=[a-z])(?=\d)", "_", with_signs)
    parts = re.split(r"([A-Za-z]+_\w+|\b[^\W\d_]\b)", text)
    # Every second part is a name: the pattern has a group.
    parts[1::2] = [symbol(name) for name in parts[1::2]]
    shown = Markup("").join(parts)
    return Markup(re.sub(r"\^(<i>\w</i>|\w)", r"<sup>\1</sup>", str(shown)))


def plain_symbol(name: str) -> str:
    """A parameter's name as a symbol in plain text."""
    head, *tail = name.split("_")
    return _letter(head) + (f"_{','.join(tail)}" if tail else "")


def safe_json(text: str) -> Markup:
    """JSON that may stand inside a script element."""
    table = {
        ord("<"): "\\u003c",
        ord(">"): "\\u003e",
        ord("&"): "\\u0026",
        0x2028: "\\u2028",
        0x2029: "\\u2029",
    }
    return Markup(text.translate(table))
