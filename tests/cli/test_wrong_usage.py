"""Wrong words on the command line end as bad input does: one line on standard error, and exit code 2."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.command import good, refused


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("fti", "log.csv"), "there is no command 'fti'. Did you mean fit?"),
        (
            ("fit", "log.csv", "--modles", "bingham"),
            "Unknown option: --modles. Did you mean --models?",
        ),
        # It stood for the whole of this folder.
        (("fit", ""), "an empty word stands behind 'fit', where a file or folder is meant."),
        (("score", "log.csv", "", "--run", "run"), "an empty word stands behind 'log.csv'"),
        (("fit", "log.csv", "--device", "coaxal"), 'Did you mean "coaxial"? erclutch fit --help'),
        (
            ("fit", "log.csv", "--seed", "two"),
            "--seed: 'two' is no whole number. erclutch fit --help",
        ),
        (
            ("fit", "log.csv", "--seed", "1.5"),
            "--seed: '1.5' is no whole number. erclutch fit --help",
        ),
        (
            ("fit", "log.csv", "--workers=2.6"),
            "--workers: '2.6' is no whole number. erclutch fit --help",
        ),
        (("fit", "log.csv", "--seed", "1.0", "--modles", "x"), "Unknown option: --modles."),
        (
            ("export", "run", "--model", "m2", "--target", "c"),
            "Unknown option: --target.",
        ),  # --model is an option
        (
            ("inspect", "-"),
            "-: a log is read from a file, not from standard input. Save it, and give the file.",
        ),
        (("report",), "RUN is missing. Write: erclutch report RUN [OPTIONS]."),
        (
            ("recalibrate", "log.csv", "--run", "any.run"),
            "--run is no option here: RUN stands without a name. Write: erclutch recalibrate RUN LOG... [OPTIONS].",
        ),
    ],
)
def test_wrong_words_are_one_line_with_the_way_out(
    words: tuple[str, ...], said: str, tmp_path: Path
) -> None:
    assert said in refused(*words, cwd=tmp_path)


def test_a_run_that_is_given_as_a_log_is_told(tmp_path: Path) -> None:
    folder = tmp_path / "first run"
    folder.mkdir()
    (folder / "run.json").write_text("{}", encoding="utf-8")
    said = refused("predict", "first run", "log.csv", cwd=tmp_path)
    assert "first run is a run: give it as --run 'first run'." in said


@pytest.mark.slow
def test_a_question_that_is_open_is_no_error(tmp_path: Path) -> None:
    rows = "\n".join(f"{i / 1000},{i % 7},{i % 5}" for i in range(60))
    (tmp_path / "log.csv").write_text(f"t [s],a,b\n{rows}\n", encoding="utf-8")
    good("inspect", "log.csv", cwd=tmp_path, code=1)
