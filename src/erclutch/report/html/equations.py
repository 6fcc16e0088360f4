"""Equations of laws are MathML, a term a formula, made from the functions that are fitted.

SymPy takes a second to make them, so they are kept in the user's cache, under a digest of what the law computes.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Callable, Sequence
from functools import cache
from importlib.metadata import version
from importlib.resources import files
from typing import Any, cast

import numpy as np
from markupsafe import Markup

from erclutch.arithmetic.operand import Operand
from erclutch.errors import RunError
from erclutch.files import cache_folder
from erclutch.files.given_files import small_json
from erclutch.models.laws import Law, law_from_name
from erclutch.models.model_file import digest_of, keeps_digest
from erclutch.models.stages import slip_stages
from erclutch.report.plots.paper_style import placed
from erclutch.signals.device import DeviceName

_MAKERS = ("models/laws/symbolic.py", "report/html/equations.py")


@cache
def terms_of(specification: str, device: DeviceName) -> tuple[Markup, ...]:
    """Gain times column of each term of a law's effort for w > 0."""
    law = law_from_name(specification, device)
    # The equation follows from what the law computes, its names, and the code that writes it.
    field: Any = _Words("E")
    if law.stimulus is not None:
        thresholds = [_Words(shape.name) for shape in law.stimulus_shape]
        field = law.stimulus(field, *thresholds)
    shapes = [_Words(shape.name) for shape in law.shape]
    columns = law.columns(field, _Words("w"), *shapes)
    gain_names = [gain.name for gain in law.gains]
    signs = [(shape.name, shape.lower >= 0) for shape in law.shape]
    digest = _digest((gain_names, signs), [_text(column) for column in columns])
    return _kept_terms(digest, lambda: made_terms(law))


@cache
def memory_terms_of(dynamics: str) -> tuple[Markup, ...]:
    """Gain times column of each term that the stages on the slip add."""
    stages = slip_stages(dynamics)
    if not stages:
        return ()
    gain_names: list[str] = []
    columns: list[str] = []
    for stage in stages:
        gain_names += [gain.name for gain in stage.gains]
        outputs = [_Words(name) for name in stage.outputs]
        columns += [_text(column) for column in stage.columns(outputs, _Words("y"))]

    def made() -> list[str]:
        from erclutch.models.laws.symbolic import memory_terms

        return _written([term for stage in stages for term in memory_terms(stage)])

    return _kept_terms(_digest(gain_names, columns), made)


def _kept_terms(digest: str, make: Callable[[], list[str]]) -> tuple[Markup, ...]:
    kept = cache_folder() / f"equation-{digest[:24]}.json"
    terms: list[str] | None = None
    with contextlib.suppress(OSError, ValueError):
        read: object = small_json(kept)
        # A disk that changed a letter would print another equation.
        if isinstance(read, dict) and keeps_digest(cast("dict[str, Any]", read)):
            terms = cast("dict[str, list[str]]", read).get("terms")
    if terms is None:
        terms = make()
        # A cache that cannot be written costs a second the next time, no more.
        with contextlib.suppress(RunError), placed(kept) as unfinished:
            body = {"terms": terms}
            text = json.dumps({**body, "digest": digest_of(body)})
            unfinished.write_text(text, encoding="utf-8")
    return tuple(map(Markup, terms))


def made_terms(law: Law) -> list[str]:
    """The terms of a law as MathML, made by SymPy now."""
    from erclutch.models.laws.symbolic import short_terms

    return _written(short_terms(law))


def _written(terms: Sequence[tuple[Any, Any]]) -> list[str]:
    from sympy.printing.mathml import mathml

    def written(gain: Any, column: Any) -> str:
        body = str(mathml(column, printer="presentation"))
        fenced = f"<mo>(</mo>{body}<mo>)</mo>" if column.is_Add else body
        return str(mathml(gain, printer="presentation")) + fenced

    return [written(gain, column) for gain, column in terms]


class _Words(Operand):
    """An operand that writes down in words what is done to it."""

    __slots__ = ("text",)

    def __init__(self, text: str) -> None:
        self.text = text

    def __array_ufunc__(
        self,
        ufunc: np.ufunc,
        method: str,
        *inputs: Any,
        **kwargs: Any,
    ) -> Any:
        return _Words(f"{ufunc.__name__}.{method}({', '.join(map(_text, inputs))}{kwargs or ''})")


def _text(x: Any) -> str:
    return x.text if isinstance(x, _Words) else repr(x)


def _digest(names: Any, columns: Sequence[str]) -> str:
    names_and_columns = repr((names, columns, version("sympy")))
    digest = hashlib.sha256(names_and_columns.encode())
    for maker in _MAKERS:
        digest.update(files("erclutch").joinpath(maker).read_bytes())
    return digest.hexdigest()
