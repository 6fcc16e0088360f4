"""``erclutch cite`` prints what `CITATION.cff` holds."""

from __future__ import annotations

from typing import Annotated, Literal

from cyclopts import Parameter

from erclutch._version import __version__

COMMAND = {
    "help": "Print how to cite erclutch and the paper: as text or BibTeX.",
    "panel": "About",
    "place": 3,
}

AUTHORS = "The erclutch authors"
PAPER_AUTHORS = ("Huang", "Ishikawa")
PAPER = "Torque Transmission Modeling of Two Coaxial Electrorheological Clutches for Reciprocating Actuation"
_TEXT = f"{AUTHORS}. erclutch, version {__version__}. Software, Apache-2.0.\n{' and '.join(PAPER_AUTHORS)}. {PAPER}.\n"
_BIBTEX = f"""@software{{erclutch,
  author  = {{{{{AUTHORS}}}}},
  title   = {{erclutch}},
  version = {{{__version__}}},
  license = {{Apache-2.0}}
}}
@article{{huang-ishikawa,
  author = {{{" and ".join(PAPER_AUTHORS)}}},
  title  = {{{PAPER}}}
}}
"""


def cite(*, to: Annotated[Literal["text", "bibtex"], Parameter(negative=())] = "text") -> None:
    """Print how to cite erclutch, and the paper whose models it implements.

    Args:
        to: Format: text or bibtex.
    """
    import sys

    sys.stdout.write(_BIBTEX if to == "bibtex" else _TEXT)
