"""Foreign text goes into an exported file through the one encoder of its place.

Foreign is what erclutch did not write itself: names of columns, units, titles of plug-ins, paths.
"""

from __future__ import annotations

import html
import unicodedata

from erclutch.errors import printable

#: What would end a comment or a docstring, or join it with the next line, in one of the languages that are written.
_BREAKS = (("*/", "* /"), ("/*", "/ *"), ("??", "? ?"), ("--", "- -"), ("\\", "|"), ('"', "'"))

_LATEX = {
    **{c: f"\\{c}" for c in "{}$&#_%"},
    **{"\\": "\\textbackslash{}", "^": "\\textasciicircum{}", "~": "\\textasciitilde{}"},
    **{"<": "\\textless{}", ">": "\\textgreater{}", "|": "\\textbar{}"},
    **{"·": "$\\cdot$", "–": "--", "−": "$-$", "∞": "$\\infty$", "√": "$\\surd$", "′": "$'$"},
}
_FONT = "°µ×±ßæÆøØ"  # beside letters with accents, which TeX composes
_CAPITALS = {"GAMMA", "DELTA", "THETA", "LAMBDA", "XI", "PI", "SIGMA", "UPSILON", "PHI", "PSI", "OMEGA"}


def comment(text: str) -> str:
    """A text as one line of a comment in C, C++, MATLAB or XML, or of a Python docstring: ASCII that ends neither."""
    shown = "".join(c if c.isascii() else f"<U+{ord(c):04X}>" for c in printable(text))
    for mark, instead in _BREAKS:
        while mark in shown:
            shown = shown.replace(mark, instead)
    return shown


def c_string(text: str) -> str:
    """A text as a string literal of C and C++, with its quotes; its bytes are UTF-8."""
    plain = set(range(32, 127)) - set(b'"\\?')
    return '"' + "".join(chr(b) if b in plain else f"\\{b:03o}" for b in text.encode("utf-8", "replace")) + '"'


def matlab_string(text: str) -> str:
    """A text as a string literal of MATLAB and Octave, with its quotes."""
    return "'" + printable(text).replace("'", "''") + "'"


def markup(text: str) -> str:
    """A text between tags or in an attribute of XML and HTML."""
    return html.escape(printable(text))


def latex(text: str) -> str:
    """A text in the running text of LaTeX; what the fonts of pdflatex lack is named by its number."""
    return "".join(_LATEX.get(c) or _letter(c) for c in printable(text))


def _letter(c: str) -> str:
    if c.isascii() or c in _FONT or (unicodedata.decomposition(c)[:2] == "00" and ord(c) < 0x180):
        return c
    plain = unicodedata.normalize("NFKC", c)
    kind, _, letter = unicodedata.name(c, "").replace("LAMDA", "LAMBDA").partition(" LETTER ")
    if kind.startswith("SUPERSCRIPT") and plain in "−0123456789":
        return f"$^{{{plain.replace('−', '-')}}}$"
    if plain != c:
        return latex(plain)
    if letter in _CAPITALS or (kind == "GREEK SMALL" and letter.isalpha() and letter != "OMICRON"):
        return f"$\\{letter.capitalize() if kind == 'GREEK CAPITAL' else letter.lower()}$"
    return f"{{[}}U+{ord(c):04X}{{]}}"


def markdown(text: str) -> str:
    """A text in a cell of a table in Markdown."""
    return "".join(f"\\{c}" if c in "\\`*_[]<>|" else c for c in printable(text))
