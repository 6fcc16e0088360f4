from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
import sympy

from erclutch.models.laws import Law, law_from_name
from erclutch.models.laws.law import YIELD, ShapeParameter
from erclutch.models.laws.smooth import TRANSITION_SLIP, direction, power
from erclutch.models.laws.symbolic import equation, equation_latex, equation_text, symbol_latex


@pytest.mark.slow
def test_equation_equals_the_columns_times_gains(
    law: Law,
    columns: Callable[[Law, Any, Any, Sequence[Any]], tuple[Any, ...]],
    point: Callable[[Law, Sequence[float]], list[float]],
) -> None:
    rng = np.random.default_rng(3)
    expression = equation(law)
    shapes = (*law.stimulus_shape, *law.shape)
    names = ["E", "w", *(s.name for s in shapes), *(g.name for g in law.gains)]
    symbols = {s.name: s for s in expression.free_symbols}
    assert set(symbols) <= set(names)
    function = sympy.lambdify(
        [symbols.get(name, sympy.Symbol(name)) for name in names], expression, "numpy"
    )
    E, w = rng.uniform(0.1, 1.2, 40), rng.uniform(0.1, 3.0, 40)
    for _ in range(5):
        q = point(law, rng.uniform(0.25, 0.75, len(shapes)).tolist())
        if law.name == "casson":  # its root is regularised where y r |w| nears 1e-6
            q = [
                0.3 if s.name == "r" else 1.5 if s.name == "n" else v
                for s, v in zip(shapes, q, strict=True)
            ]
        gains = rng.uniform(0.5, 2.0, len(law.gains))
        expected = sum(g * c for g, c in zip(gains, columns(law, E, w, q), strict=True))
        np.testing.assert_allclose(function(E, w, *q, *gains), expected, rtol=1e-7)


@pytest.mark.parametrize(
    "specification", ["bingham/square", "bingham/power", "hem/square", "quadratic"]
)
def test_text_is_the_published_equation(specification: str) -> None:
    published = {
        "bingham/square": "T_y*E^2*tanh(w/w_s) + eta*w",
        "bingham/power": "T_y*E^n*tanh(w/w_s) + eta*w",
        "hem/square": "T_y*E^2*tanh(w/w_s) + eta_0*w*(1 + kappa*(exp(beta*E) - 1)/(exp(beta) - 1))",
        "quadratic": "T_y*E^2*tanh(w/w_s) + eta*w",
    }[specification]
    # A symbol for each name: SymPy's parser would take E for Euler's number.
    names = {
        name: sympy.Symbol(name)
        for name in ("E", "w", "w_s", "n", "T_y", "eta", "eta_0", "kappa", "beta")
    }
    parse: Any = sympy.sympify
    got, expected = (
        parse(text.replace("^", "**"), locals=names)
        for text in (equation_text(law_from_name(specification)), published)
    )
    assert sympy.simplify(got - expected) == 0


def test_text_of_every_law_is_one_readable_line(law: Law) -> None:
    text = equation_text(law)
    assert "\n" not in text
    assert "**" not in text
    assert "1e-12" not in text
    for parameter in (*law.stimulus_shape, *law.shape, *law.gains):
        assert parameter.name in text


@pytest.mark.slow
def test_a_power_of_a_power_has_a_short_exponent() -> None:
    def columns(E: Any, w: Any, w_s: Any, m: Any, n: Any) -> tuple[Any, ...]:
        return (power(power(power(E, n), 1.0 / m) + np.abs(w), m) * direction(w, w_s),)

    shape = (TRANSITION_SLIP, ShapeParameter("m", "", 0.2, 3.0), ShapeParameter("n", "", 0.5, 3.0))
    law = Law(name="sum", title="Sum", source="", columns=columns, shape=shape, gains=(YIELD,))
    assert equation_text(law) == "T_y*(E^(n/m) + w)^m*tanh(w/w_s)"


def test_a_function_without_a_symbol_is_refused() -> None:
    from erclutch.models.laws.symbolic import Symbolic

    unknown: Any = np.arctan2
    with pytest.raises(TypeError):
        unknown(Symbolic(sympy.Symbol("x")), 1.0)


def test_latex_has_each_parameter_and_no_fraction_of_rounding(law: Law) -> None:
    text = equation_latex(law)
    for parameter in (*law.stimulus_shape, *law.shape, *law.gains):
        assert symbol_latex(parameter.name) in text
    assert not re.search(r"[1-9]\d{4}", text)


@pytest.mark.parametrize(
    ("specification", "latex"),
    [
        ("quadratic", r"T_{y} E^{2} \tanh{\left(\frac{w}{w_{s}} \right)} + \eta w"),
        ("bingham/square/forward", r"T_{y} E^{2} + \eta w"),
        ("herschel-bulkley/power/forward", r"T_{y} E^{n} + K w^{m}"),
    ],
)
def test_latex_reads_as_published(specification: str, latex: str) -> None:
    assert equation_latex(law_from_name(specification)) == latex
