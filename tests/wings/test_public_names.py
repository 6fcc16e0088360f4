"""Names of the package that come with a wing are there, and one line says which wing is missing."""

from __future__ import annotations

import sys

import pytest

import erclutch
from erclutch.errors import ErclutchError

NAMES = {
    name: home.split(".")[1]
    for name, home in erclutch._HOME_OF.items()
    if home.startswith("wings.")
}


@pytest.mark.parametrize("name", NAMES)
def test_a_name_of_a_wing_is_there(name: str) -> None:
    assert name in erclutch.__all__
    assert getattr(erclutch, name) is not None


@pytest.mark.parametrize("name", NAMES)
def test_a_wing_that_is_missing_is_named(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    wing = NAMES[name]
    for module in [known for known in sys.modules if known.startswith(f"erclutch.wings.{wing}")]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.delitem(vars(erclutch), name, raising=False)

    def absent(module: str) -> None:
        raise ModuleNotFoundError(f"No module named {module!r}", name=f"erclutch.wings.{wing}")

    monkeypatch.setattr("erclutch.importlib.import_module", absent)
    with pytest.raises(ErclutchError) as caught:
        getattr(erclutch, name)
    assert str(caught.value) == (
        f"erclutch.{name} needs the wing {wing}, whose folder is not there. "
        "Install erclutch whole: its package has all wings."
    )
