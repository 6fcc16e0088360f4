"""Symbols as a page shows them, and data that may stand inside one."""

from __future__ import annotations

from markupsafe import Markup

_GREEK = {
    "alpha": "α",
    "beta": "β",
    "eta": "η",
    "kappa": "κ",
    "mu": "μ",
    "rho": "ρ",
    "sigma": "σ",
    "tau": "τ",
    "theta": "θ",
}


def symbol(name: str) -> Markup:
    """A parameter's name as a symbol: ``eta_0_1`` is an eta with the index 0,1."""
    head, *tail = name.split("_")
    letter = _GREEK.get(head, head)
    body = Markup("<span class=word>{}</span>" if len(letter) > 2 else "<i>{}</i>").format(letter)
    if not tail:
        return body
    return body + Markup("<sub>{}</sub>").format(", ".join(_GREEK.get(t, t) for t in tail))


def plain_symbol(name: str) -> str:
    """The same in plain text."""
    head, *tail = name.split("_")
    return _GREEK.get(head, head) + (f"_{','.join(tail)}" if tail else "")


def safe_json(text: str) -> Markup:
    """JSON that may stand inside a script element."""
    table = {ord("<"): "\\u003c", ord(">"): "\\u003e", ord("&"): "\\u0026", 0x2028: "\\u2028", 0x2029: "\\u2029"}
    return Markup(text.translate(table))
