"""The name of a column may state at which arm a sensor works: ``Load cell (r=0.15 m)``, ``Force @ 150 mm``."""

from __future__ import annotations

import re

from erclutch.errors import UnitError
from erclutch.signals import units

# Blanks and brackets are run through once from where they begin: a name may have thousands.
_ARM = re.compile(
    r"(?<![\s_(\[])[\s_(\[]*+(?:(?<![^\W\d_])(?:am|at|auf|an|à|a|@)?\s*+"
    r"(?:r|radius|arm|lever|hebel(?:arm)?|bras|brazo|braccio|半径|力臂)"
    r"\s*+(?:r|of|von|de)?\s*+=?|@|\bat)\s*+(\d+(?:[.,]\d+)?)\s?(mm|cm|m|in|inch)(?![^\W\d_])[)\]]*",
    re.IGNORECASE,
)


def arm_in(name: str) -> float | None:
    """The length in m of the arm that the name of a column states; None for none or several."""
    stated = _ARM.findall(name)
    if len(stated) != 1:
        return None
    number, unit = stated[0]
    try:
        return units.in_unit(f"{number.replace(',', '.')} {unit}", "m")
    except UnitError:
        return None


def without_arm(name: str) -> str:
    """A name without the arm that it states; as it is where nothing else would be left."""
    return _ARM.sub("", name).strip() or name
