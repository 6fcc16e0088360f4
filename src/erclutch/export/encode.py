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
_CAPITALS = {
    "GAMMA",
    "DELTA",
    "THETA",
    "LAMBDA",
    "XI",
    "PI",
    "SIGMA",
    "UPSILON",
    "PHI",
    "PSI",
    "OMEGA",
}


def comment(text: str) -> str:
    """A text as one line of a comment in C, C++, MATLAB or XML, or of a Python docstring: ASCII that ends neither."""
    letters = [
        letter if letter.isascii() else f"<U+{ord(letter):04X}>" for letter in printable(text)
    ]
    shown = "".join(letters)
    for mark, instead in _BREAKS:
        while mark in shown:
            shown = shown.replace(mark, instead)
    return shown


def c_string(text: str) -> str:
    """A text as a string literal of C and C++, with its quotes; its bytes are UTF-8."""
    plain = set(range(32, 127)) - set(b'"\\?')
    letters: list[str] = []
    for byte in text.encode("utf-8", "replace"):
        letters.append(chr(byte) if byte in plain else f"\\{byte:03o}")
    return f'"{"".join(letters)}"'


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
    """A letter that LaTeX does not take for a sign of its own, by its name in Unicode."""
    with_accent = unicodedata.decomposition(c)[:2] == "00" and ord(c) < 0x180
    if c.isascii() or c in _FONT or with_accent:
        return c
    plain = unicodedata.normalize("NFKC", c)
    spelled = unicodedata.name(c, "").replace("LAMDA", "LAMBDA")
    kind, _, letter = spelled.partition(" LETTER ")
    if kind.startswith("SUPERSCRIPT") and plain in "−0123456789":
        return f"$^{{{plain.replace('−', '-')}}}$"
    if plain != c:
        return latex(plain)
    small_greek = kind == "GREEK SMALL" and letter.isalpha() and letter != "OMICRON"
    if letter in _CAPITALS or small_greek:
        command = letter.capitalize() if kind == "GREEK CAPITAL" else letter.lower()
        return f"$\\{command}$"
    return f"{{[}}U+{ord(c):04X}{{]}}"


def markdown(text: str) -> str:
    """A text in a cell of a table in Markdown."""
    return "".join(f"\\{c}" if c in "\\`*_[]<>|" else c for c in printable(text))
