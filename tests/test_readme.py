"""The README's Python runs and prints what the README says it prints; its commands exist."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_python_block_prints_what_the_readme_shows(tmp_path: Path) -> None:
    code = re.search(r"```python\n(.*?)```", README, re.DOTALL)
    shown = re.search(r"prints\n\n```text\n(.*?)```", README, re.DOTALL)
    assert code is not None
    assert shown is not None
    script = tmp_path / "block.py"
    script.write_text(code.group(1), encoding="utf-8")
    done = subprocess.run([sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == shown.group(1).strip()


def test_every_command_and_link_of_the_readme_exists() -> None:
    from erclutch.cli import app

    for command in set(re.findall(r"^erclutch (\w+)", README, re.MULTILINE)):
        assert command in app, command
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in set(re.findall(r"^make (\w+)", README, re.MULTILINE)):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
    for link in re.findall(r"\]\(([^)]+)\)", README):
        assert link.startswith("http") or (ROOT / link).exists(), link


def test_every_law_is_in_the_readme() -> None:
    from erclutch.laws import law_names

    for name in law_names():
        assert f"`{name}`" in README, name
