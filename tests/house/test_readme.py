"""The README's Python runs and prints what the README says it prints; its commands exist."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_python_block_prints_what_the_readme_shows(tmp_path: Path) -> None:
    code = re.search(r"```python\n(.*?)```", README, re.DOTALL)
    shown = re.search(r"prints\n\n```text\n(.*?)```", README, re.DOTALL)
    assert code is not None
    assert shown is not None
    script = tmp_path / "block.py"
    script.write_text(code.group(1), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == shown.group(1).strip()


def test_every_command_of_the_readme_exists() -> None:
    from erclutch.cli import app

    for command in set(re.findall(r"^erclutch (\w+)", README, re.MULTILINE)):
        assert command in app, command
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in set(re.findall(r"^make (\w+)", README, re.MULTILINE)):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


@pytest.mark.parametrize(
    "page", ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md"]
)
def test_every_link_leads_somewhere(page: str) -> None:
    for link in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", (ROOT / page).read_text(encoding="utf-8")):
        assert link.startswith("http") or (ROOT / link).exists(), link


def test_the_readme_is_short_and_its_pictures_are_small() -> None:
    assert len(README.splitlines()) <= 150
    pictures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", README)
    assert len(pictures) == 2
    for picture in pictures:
        assert (ROOT / picture).stat().st_size < 150_000, picture


def test_every_module_named_in_the_architecture_exists() -> None:
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    package = ROOT / "src" / "erclutch"
    rooms = {folder.name for folder in package.iterdir() if (folder / "__init__.py").exists()}
    named = [
        name for name in re.findall(r"`([a-z_]+(?:/[\w.]+)*)`", text) if name.split("/")[0] in rooms
    ]
    wings = {
        f"wings/{folder.name}"
        for folder in (package / "wings").iterdir()
        if (folder / "__init__.py").exists()
    }
    assert {name for name in named if "/" not in name} == rooms
    assert wings <= set(named)
    for name in named:
        assert (package / name).exists() or (package / f"{name}.py").exists(), name


def test_every_law_is_in_the_readme() -> None:
    from erclutch.models.laws import law_names

    for name in law_names():
        assert f"`{name}`" in README, name


@pytest.mark.slow
def test_rooms_import_what_the_architecture_says() -> None:
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \|[^|]*\| ([^|]*) \|$", text, re.MULTILINE)
    rooms = [room for room, _ in rows]
    for place, (room, words) in enumerate(rows):
        said = (
            set(rooms[place + 1 :])
            if words.startswith("all")
            else set(re.findall(r"`(\w+)`", words))
        )
        assert said <= set(rooms[place + 1 :]), f"{room} imports what stands above it"
        sources = (
            file.read_text(encoding="utf-8")
            for file in (ROOT / "src" / "erclutch" / room).rglob("*.py")
        )
        found = {
            name
            for text in sources
            for name in re.findall(r"(?:from|import) erclutch\.(\w+)", text)
        }
        assert found & set(rooms) - {room} <= said, room
