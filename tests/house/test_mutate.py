"""The counts of `studies/mutate.py`: which mutants there are, which are drawn, what the summary says of them."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from studies import mutate as study

ROOT = Path(__file__).parents[2]


def mutants(folder: Path, source: str, suffix: str = ".py") -> list[str]:
    path = folder / f"module{suffix}"
    path.write_text(source, encoding="utf-8")
    return [study.mutated(path, number) for number in range(len(study.sites(path)))]


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("x = a < b", {"x = a <= b", "x = a >= b"}),
        ("x = a - 2", {"x = a + 2", "x = a - 3"}),
        ("x = a and not b", {"x = a or not b"}),
        ("x = -a * 0.5", {"x = +a * 0.5", "x = -a / 0.5", "x = -a * 1.0"}),
        ("def f():\n    return x", {"def f():\n    return None"}),
        ("def f():\n    return None", set()),
        ("if a:\n    f(a)", {"if not a:\n    f(a)", "if a:\n    pass"}),
        ("x += y", {"pass", "x -= y"}),
        (
            "if a:\n    raise E(f'{a + 1}')",
            {"if not a:\n    raise E(f'{a + 1}')", "if a:\n    pass"},
        ),
    ],
)
def test_each_defect_is_made(tmp_path: Path, source: str, expected: set[str]) -> None:
    made = mutants(tmp_path, source)
    assert set(made) == expected
    assert len(made) == len(expected)


def test_words_and_types_are_left_alone(tmp_path: Path) -> None:
    source = (
        '"""Doc: 1 + 1."""\nx: Literal[3]\n\n@cache(4)\ndef f(a: T[1]) -> U[2]:\n'
        '    zip(a, strict=True)\n    b = f"{a + 1}"\n'
    )
    assert len(mutants(tmp_path, source)) == 1  # the call, dropped


def test_c_is_changed_outside_comments_and_texts(tmp_path: Path) -> None:
    source = '#define A (1 + 2)\n/* a < b\n c > d */\nint x = a && *b; // e + f\nchar *y = "1 < \\" - 2", z = \'"\';\n'
    assert mutants(tmp_path, source, ".c") == [source.replace("&&", "||")]


@pytest.mark.slow
def test_a_longer_sample_begins_with_the_shorter_one() -> None:
    long = study.sample(ROOT, ["signals", "live"], seed=3, count=20)
    assert study.sample(ROOT, ["signals", "live"], seed=3, count=8) == long[:8]
    assert long != study.sample(ROOT, ["signals", "live"], seed=4, count=20)
    assert {mutant["room"] for mutant in long} == {"signals", "live"}


@pytest.mark.slow
def test_the_tests_that_call_a_function_meet_its_mutants() -> None:
    text = (
        "class A:\n    def f(self):\n        def g():\n            return 1\n        return g\n\n\n"
    )
    text += "def h(x=2):\n    return x\n"
    found = [study.function_at(ast.parse(text), line) for line in range(1, 10)]
    assert found == ["", "", "A.f", "A.f.<locals>.g", "A.f", "", "", "", "h"]
    mutant = {"room": "signals", "file": "signals/clock.py", "line": 1}
    line = next(
        n
        for n, code in enumerate(
            (ROOT / study.PACKAGE / mutant["file"]).read_text().splitlines(), 1
        )
        if "edges[::2]" in code
    )
    files = study.files_of(ROOT, "signals", ROOT / study.PACKAGE / mutant["file"])
    assert {"tests/signals/test_device.py", "tests/signals/test_differentiate.py"} <= set(files)
    seen = {
        file: {"signals/clock.py:stretches": [f"{file}::test_a"]} if file == files[0] else {}
        for file in files
    }
    assert study.tests_of(ROOT, {**mutant, "line": line}, seen) == [f"{files[0]}::test_a"]
    assert study.tests_of(ROOT, mutant, seen) == files


@pytest.mark.slow
def test_where_no_test_of_the_room_imports_a_module_others_that_do_count() -> None:
    files = study.files_of(ROOT, "fit", ROOT / study.PACKAGE / "fit/networks/exchange.py")
    assert files[0] == "tests/models/networks/test_exchange.py"
    assert files[-1].startswith("tests/fit/")
    files = study.files_of(ROOT, "fit", ROOT / study.PACKAGE / "fit/history.py")
    assert files[0] == "tests/fit/test_history.py"
    assert all(file.startswith("tests/fit/") for file in files)


def test_a_judged_survivor_counts_neither_way() -> None:
    places = [
        {"file": "a.py", "line": n, "what": "Lt -> LtE", "code": f"x < {n}"} for n in range(4)
    ]
    said = ["killed: t", "killed: t", "survived", "survived"]
    outcomes = [{**place, "outcome": outcome} for place, outcome in zip(places, said, strict=True)]
    judged = [
        {"file": "a.py", "code": "x < 2", "what": "Lt -> LtE", "reason": "a tie has no meaning"}
    ]
    told = study.summary(outcomes, judged)
    assert "4 mutants: 2 killed, 1 without effect or promise, 1 survived; 2 of 3" in told
    assert "a.py:3: Lt -> LtE in `x < 3`: SURVIVED" in told
    assert "x < 2`: a tie has no meaning" in told
