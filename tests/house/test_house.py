"""The limits of the house: rooms, arrows, names, import tricks and circles, counted by `studies/house.py`."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from studies import house as study

ROOT = Path(__file__).parents[2]

#: Places where the name of a module is data: the lazy names of the package and of its logs, a plug-in, a module that
#: was exported, and the reader that a child runs.
TRICKS = {
    "__init__.py",
    "logs/__init__.py",
    "registry.py",
    "wings/exporters/targets/mujoco.py",
    "logs/readers/reader_in_child.py",
}


@pytest.fixture(scope="module")
def house() -> Any:
    return study.House(ROOT)


def test_few_rooms_and_few_modules_on_the_ground_floor(house: Any) -> None:
    assert len(house.rooms) <= 10
    assert len(house.wings) <= 9
    assert len(house.ground_floor) <= 4


def test_the_layers_are_few_lines(house: Any) -> None:
    # Ten lines of the core, four of the wings, and the inner layers of the two largest rooms: fits and logs.
    assert 0 < house.contract_lines <= 24


@pytest.mark.slow
def test_no_arrow_points_up(house: Any) -> None:
    assert list(house.arrows_up) == []


@pytest.mark.slow
def test_no_function_is_long(house: Any) -> None:
    lengths = [length for length, _ in house.functions]
    assert lengths[-1] <= 100, house.functions[-1]


@pytest.mark.slow
def test_no_file_is_long(house: Any) -> None:
    assert house.longest_file[0] <= 450, house.longest_file


@pytest.mark.slow
def test_a_logs_way_is_short_past_the_rules_of_reading(house: Any) -> None:
    stays = house.way_of_a_log
    assert len(stays) <= 30, stays
    assert len(stays) - len(set(stays)) <= 10, stays


@pytest.mark.slow
def test_tests_need_no_study() -> None:
    """What both need stands in tests/support; `studies` are not shipped with the tests."""
    own = {"test_house.py", "test_mutate.py", "test_study_of_formats.py"}  # of the study itself
    takers = {
        path.name
        for path in ROOT.glob("tests/**/*.py")
        if re.search(r"^ *(from|import) studies\b", path.read_text(), re.M)
    }
    assert takers <= own


@pytest.mark.slow
def test_modules_are_imported_by_name(house: Any) -> None:
    assert {place.rpartition(":")[0] for place in house.import_tricks} <= TRICKS


@pytest.mark.slow
def test_no_module_needs_one_that_needs_it(house: Any) -> None:
    assert house.circles(lazy=False) == []
    assert house.circles(lazy=True) == []


@pytest.mark.slow
def test_no_c_file_needs_one_that_needs_it(house: Any) -> None:
    assert house.c_circles() == []


@pytest.mark.slow
def test_no_two_classes_share_a_name(house: Any) -> None:
    assert house.shared_classes == {}


@pytest.mark.slow
def test_no_two_modules_share_a_name(house: Any) -> None:
    assert house.shared_stems == {}


@pytest.mark.slow
def test_few_ask_of_which_kind_a_model_is(house: Any) -> None:
    assert len(house.model_kinds) <= 5


@pytest.mark.slow
def test_the_alias_of_arrays_stands_once(house: Any) -> None:
    assert house.places(r"^Array(: TypeAlias)? = NDArray\[np\.float64\]") == ["signals/array.py:8"]


# --- the counts themselves -------------------------------------------------------------------------------------------


@pytest.fixture
def small(tmp_path: Path) -> Any:
    """A package with one of everything that is counted."""
    files = {
        "__init__.py": "",
        "errors.py": "class Fault(Exception):\n    pass\n",
        "one/__init__.py": "",
        "one/first.py": (
            '"""Docstring: import_module(\'x\'), a - b."""\n'
            "from importlib import import_module\n"
            "from erclutch.one.second import g\n"
            "class Fault:\n    pass\n"
            "def f(x):\n    return isinstance(x, (int, TorqueModel)) and import_module('numpy')\n"
        ),
        "one/second.py": "def g():\n    from erclutch.one.first import f\n    return f\n",
        "one/a.h": "void b_call(void);\nvoid a_call(void);\n",
        "one/a.c": '#include "a.h"\nvoid a_call(void) {\n    b_call();\n}\n',
        "one/b.c": '#include "a.h"\nvoid b_call(void) {\n}\n',
    }
    for name, text in files.items():
        path = tmp_path / "src" / "erclutch" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    (tmp_path / "pyproject.toml").write_text(
        '[[tool.importlinter.contracts]]\nlayers = ["one", "errors"]\n'
    )
    return study.House(tmp_path)


def test_what_is_counted_is_found(small: Any) -> None:
    assert small.rooms == ["one"]
    assert small.ground_floor == ["errors"]
    assert small.contract_lines == 2
    assert small.import_tricks == ["one/first.py:7"]
    assert small.model_kinds == ["one/first.py:7"]
    assert small.shared_classes == {"Fault": ["errors.py", "one/first.py"]}
    assert small.lines((".c", ".h")) == 9
    assert [length for length, _ in small.functions] == [2, 3]


def test_circles_are_found(small: Any) -> None:
    assert small.circles(lazy=False) == []
    assert small.circles(lazy=True) == [["erclutch.one.first", "erclutch.one.second"]]
    assert small.c_circles() == [["a", "b"]]


def test_the_code_is_without_what_is_said(small: Any) -> None:
    first = next(module for module in small.modules if module.path.name == "first.py")
    assert "Docstring" not in first.code
    assert "isinstance" in first.code
    assert small.places("import_module") == ["one/first.py:2", "one/first.py:7"]


@pytest.mark.slow
def test_a_logs_way_is_counted_past_the_rules_of_a_table_and_through_them(tmp_path: Path) -> None:
    files = {
        "logs/read_logs.py": (
            "from erclutch.logs.plan import plan_of\nfrom erclutch.logs.applied import apply\n"
            "def read(path):\n    return apply(plan_of(path))\n"
        ),
        "logs/plan.py": (
            "from erclutch.logs.one_rule import guess\nfrom erclutch.logs.other_rule import doubt\n"
            "STEPS = (Step('a guess', guess), Step('a doubt', rule=doubt))\n"
            "def plan_of(path):\n    for step in STEPS:\n        step.rule(path)\n    return _made(path)\n"
            "def _made(path):\n    return path\n"
        ),
        "logs/one_rule.py": "def guess(path):\n    pass\n",
        "logs/other_rule.py": "def doubt(path):\n    pass\n",
        "logs/applied.py": "def apply(plan):\n    return plan\n",
    }
    for name, text in files.items():
        path = tmp_path / "src" / "erclutch" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    package = study.House(tmp_path)
    past_the_rules = ["logs/read_logs.py", "logs/plan.py", "logs/applied.py"]
    assert package.way_of_a_log == past_the_rules
    rules = ["logs/one_rule.py", "logs/other_rule.py"]
    assert package.way_through_all_rules == [
        *past_the_rules[:2],
        *rules,
        *past_the_rules[1:],
    ]
