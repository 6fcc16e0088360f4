"""How many levels of the field there are, and whether they tell all numbers of the way over the field."""

from __future__ import annotations

import numpy as np

from erclutch.logs.dataset import Dataset
from erclutch.models.structure import Structure


def more_numbers_than_fields(train: Dataset, structure: Structure) -> bool:
    """Whether the fields are too few to tell friction, yield effort and the form of the yield effort apart."""
    form = structure.law.yield_form
    if form is None:
        return False
    field = np.abs(train.elements[0].field)
    largest = float(field.max()) or 1.0
    levels = np.unique(np.round(field / largest, 2))
    return levels.size < 2 + len(form.shape)
