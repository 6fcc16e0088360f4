"""A header is read once in a file; another header of the same name stops the compiler, which skipped it in silence."""

from __future__ import annotations

import hashlib


def once(macro: str, text: str) -> str:
    """The text of a header between its guards.

    Args:
        macro: that says that the header was read, such as ``BRAKE_H``.
        text: all that stands between the guards; a digest of it tells this header from another one of its name.
    """
    this_one = f"{macro}_{hashlib.sha256(text.encode()).hexdigest()[:16]}"
    return f"""#ifndef {macro}
#define {macro}
#define {this_one}

{text.rstrip()}

#elif !defined({this_one})
#error "two headers of one name, which say different things: export one of them under another name"
#endif
"""
