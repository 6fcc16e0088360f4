"""Who takes part. Imports nothing heavy: the parent process stays small."""

from __future__ import annotations

from dataclasses import dataclass

GROUPS = {
    "fnn": "FNN-16: a network with one hidden layer of 16, all weights",
    "rbfm": "RBFM-10 (rbfm-10/forward): 22 bounded linear parameters",
    "hem": "HEM (hem/forward): 2 nonlinear and 4 linear parameters",
    "seo-seo": "Seo-Seo (seo-seo/forward): 2 nonlinear and 4 linear parameters",
    "cho-choi-jhon": "CCJ (cho-choi-jhon/forward): 4 nonlinear and 4 linear parameters",
    "call": "FNN-16: prediction of one sample",
}


@dataclass(frozen=True)
class Contender:
    """One fit, or one way to predict.

    Attributes:
        group: of `GROUPS`.
        name: what the table shows; erclutch's own begin with "erclutch".
        package: what pip has to install; "" where erclutch's own dependencies are enough.
    """

    group: str
    name: str
    package: str = ""

    @property
    def ours(self) -> bool:
        """Whether it is erclutch."""
        return self.name.startswith("erclutch")


_LAW = ("erclutch", ""), ("scipy least_squares trf", ""), ("lmfit leastsq", "lmfit")

_BY_GROUP: dict[str, tuple[tuple[str, str], ...]] = {
    "fnn": (
        ("erclutch", ""),
        ("erclutch polish", ""),
        ("NumPy LM as trainlm", ""),
        ("scipy least_squares lm", ""),
        ("scipy least_squares trf", ""),
        ("scikit-learn lbfgs", "scikit-learn"),
        ("scikit-learn adam", "scikit-learn"),
        ("torch Adam cosine", "torch"),
        ("torch Adam cosine, limit/4", "torch"),
        ("torch LBFGS", "torch"),
        ("torch-levenberg-marquardt", "torch torch-levenberg-marquardt"),
        ("jax-sysid", "jax jaxlib jax-sysid"),
    ),
    "rbfm": (
        ("erclutch", ""),
        ("scipy lsq_linear trf", ""),
        ("scipy lsq_linear bvls", ""),
        ("scipy SLSQP", ""),
    ),
    "hem": _LAW,
    "seo-seo": _LAW,
    "cho-choi-jhon": _LAW,
    "call": (("erclutch", ""), ("scikit-learn", "scikit-learn"), ("torch", "torch")),
}

CONTENDERS = tuple(
    Contender(group, *entry) for group, entries in _BY_GROUP.items() for entry in entries
)
