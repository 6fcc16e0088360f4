"""Names of C: what an export is called gives the names of its files and functions."""

from __future__ import annotations

import re
import unicodedata

from erclutch.errors import ExportError

#: So many characters of a name leave room: what is built from it stays within 31, which C tells apart.
_LONGEST_NAME = 20
# Words of C and C++, and names that would meet others.
_WORDS = (
    "alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl concept "
    "const const_cast consteval constexpr constinit continue decltype default delete do double "
    "dynamic_cast else enum explicit export extern false float for friend goto if inline int long mutable "
    "namespace new noexcept not not_eq nullptr operator or or_eq private protected public register "
    "reinterpret_cast requires restrict return short signed sizeof static static_assert static_cast "
    "struct switch template this thread_local throw true try typedef typeid typename union unsigned using "
    "virtual void volatile wchar_t while xor xor_eq main erc_model"
)
KEYWORDS = frozenset(_WORDS.split())
# Headers of C: a file of that name beside the exported ones would be included in their place.
_OTHER_HEADERS = (
    "assert complex ctype errno fenv inttypes iso646 limits locale math memory setjmp signal stdalign stdarg stdatomic "
    "stdbool stddef stdint stdio stdlib stdnoreturn string strings tgmath threads time uchar wchar wctype"
)
_HEADERS = frozenset(_OTHER_HEADERS.split())
_OURS = "erc_"  # begins the files of the loop, which a controller holds


def c_name(model: str, wanted: str | None = None) -> str:
    """Prefix of all C names, and so the name of the C file: the one that is wanted, else made from the model's.

    A specification that is too long is not cut: the law, or the network, gives its name.

    Raises:
        ExportError: what is wanted will not do.
    """
    if wanted is None:
        whole = "_".join(_words(model))
        if len(whole) <= _LONGEST_NAME:
            return whole
        return named_after(model.partition("+")[0])
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", wanted) or wanted in KEYWORDS or "__" in wanted:
        raise ExportError(
            f"{wanted!r} is no name for C functions",
            where="--name",
            remedy="Give a C identifier: a letter, then letters, digits and single underscores; no keyword",
        )
    if wanted.lower() in _HEADERS or wanted.lower().startswith(_OURS):
        raise ExportError(
            f"{wanted}.h is the name of another header",
            where="--name",
            remedy=f"Give a name that no header of C has and that does not begin with {_OURS}",
        )
    if len(wanted) > _LONGEST_NAME:
        raise ExportError(
            f"{wanted!r} has {len(wanted)} characters; C compilers need only tell 31 of {wanted}_inverse apart",
            where="--name",
            remedy=f"Give at most {_LONGEST_NAME} characters",
        )
    return wanted


def named_after(text: str) -> str:
    """A prefix of C names from a log's name or a law's: its first words and ``model``, such as ``damper_model``."""
    words = _words(text)
    if words and not words[0][0].isalpha():
        words.insert(0, "log")
    while words and len("_".join([*words, "model"])) > _LONGEST_NAME:
        words.pop()
    return "_".join([*words, "model"])


_UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss"})


def _words(text: str) -> list[str]:
    """Words of small letters that C knows: an umlaut is two letters, any other accent is left out."""
    spelled = unicodedata.normalize("NFC", text.lower()).translate(_UMLAUTS)
    bare = unicodedata.normalize("NFKD", spelled).encode("ascii", "ignore").decode()
    bare = re.sub(r"(?<=\d)[.,](?=\d)", "p", bare)  # 0.25 A cut at its point would be 0
    return re.findall(r"[a-z0-9]+", bare)
