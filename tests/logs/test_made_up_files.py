"""Made-up files in forms that loggers write are read right at once, or asked about: never misread."""

from __future__ import annotations

from pathlib import Path

import pytest

from erclutch.logs.readers.text_bytes import decode
from tests.support.made_up_files import ASKED, MISREAD, RIGHT, tried


@pytest.mark.slow
def test_a_few_made_up_files_are_read_right(tmp_path: Path) -> None:
    assert tried((2, 3), tmp_path)[RIGHT] == 2


@pytest.mark.slow
def test_made_up_files_are_never_misread(tmp_path: Path) -> None:
    outcomes = tried(range(1000, 1012), tmp_path)
    assert outcomes[MISREAD] == 0
    assert outcomes[ASKED] <= 1


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        ("时间(秒),位移(mm),载荷(kN)\n0,1,2\n", "gb18030"),
        ("采样时间,电机转速,制动扭矩\n0,1,2\n", "gb18030"),
        ("時間 [s],回転数 [rpm],トルク [Nm]\n0,1,2\n", "shift_jis"),
        ("時間,変位,荷重\n0,1,2\n", "shift_jis"),
        ("No,ｽﾞﾘ速度(1/s),ﾄﾙｸ\n0,1,2\n", "shift_jis"),
        ("時間,変位,荷重\n0,1,2\n", "euc_jp"),
        ("試料,ER流体\nせん断速度[1/s],粘度[Pa・s]\n0,1\n", "iso2022_jp"),
        ("Zeit;Dämpferkraft;Größe °C\n0;1;2\n", "latin-1"),
        ("Temps;Déplacement;Température\n0;1;2\n", "latin-1"),
        ("t;µm;°;²\n0;1;2;3\n", "latin-1"),
    ],
)
def test_text_that_is_no_utf_8_is_read_by_the_words_of_measuring(text: str, encoding: str) -> None:
    assert decode(text.encode(encoding)) == text
