"""The directive ``picture``: commands that a reader can repeat, run while the site is built, and the picture they make.

    ```{picture} figures/trace.png figures/parity.png
    :data: TWIN
    :alt: what is to be seen in the first; in the second
    erclutch simulate training --seconds 5
    ```

A picture of a recording that is not shipped (``:needs: folder/file`` below ``../shared/data``) is left out where the
recording is absent, and the page says so.
"""

from __future__ import annotations

import atexit
import os
import shutil
import subprocess
import sys
import tempfile
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from tests.support.warm_start import WarmStart

ROOT = Path(__file__).resolve().parents[2]
RECORDINGS = ROOT.parent / "shared" / "data"
_LONGEST = 600


@cache
def _warm() -> WarmStart:
    """`erclutch` without the second that each start of it takes, until this process ends."""
    until_the_end = ExitStack()
    atexit.register(until_the_end.close)
    folder = until_the_end.enter_context(tempfile.TemporaryDirectory(prefix="erclutch-"))
    return until_the_end.enter_context(WarmStart(Path(folder)))


def run_commands(commands: str, folder: Path) -> None:
    """Run them in a folder as a reader would, with this environment's ``erclutch``.

    Raises:
        RuntimeError: one of them failed.
    """
    path = os.pathsep.join((str(Path(sys.executable).parent), os.environ.get("PATH", "")))
    surroundings = _warm().environment(
        {**os.environ, "PATH": path, "COLUMNS": "100", "NO_COLOR": "1"}
    )
    done = subprocess.run(
        ["bash", "-eu", "-c", commands],
        cwd=folder,
        env=surroundings,
        capture_output=True,
        text=True,
        timeout=_LONGEST,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"{commands}\n{done.stdout}\n{done.stderr}")


def kept_as(page: str, picture: str) -> str:
    """Name below _pictures of a page's picture: with its folder, since runs side by side draw files of one name."""
    return f"{page}/{picture}".replace("/", "-")


class PictureDirective(SphinxDirective):
    """See the module."""

    has_content = True
    required_arguments = 1
    optional_arguments = 0
    final_argument_whitespace = True
    option_spec: ClassVar[dict[str, Any]] = {
        "data": directives.unchanged_required,
        "alt": directives.unchanged_required,
        "needs": directives.unchanged,
    }

    def run(self) -> list[nodes.Node]:
        """Called by Sphinx."""
        commands = "\n".join(self.content)
        shown = nodes.literal_block(commands, commands, language="sh")
        source = RECORDINGS / self.options["needs"] if "needs" in self.options else None
        if source is not None and not source.is_file():
            text = f"*No picture here: this site was built without the recording. Data: {self.options['data']}.*"
            return [shown, *self.parse_text_to_nodes(text)]
        try:
            targets = self._made(commands, source)
        except (RuntimeError, OSError, subprocess.TimeoutExpired) as error:
            raise self.error(f"the commands of a picture failed: {error}") from error
        pictures = [
            nodes.image(uri=f"/_pictures/{target}", alt=alt.strip(), classes=["drawn-picture"])
            for target, alt in zip(targets, self.options["alt"].split(";"), strict=True)
        ]
        caption = self.parse_text_to_nodes(f"*Data: {self.options['data']}.*")
        return [shown, *pictures, *caption]

    def _made(self, commands: str, source: Path | None) -> list[str]:
        """Names of the pictures below _pictures, which `make docs` empties and no repository holds."""
        kept = Path(self.env.srcdir) / "_pictures"
        kept.mkdir(exist_ok=True)
        names: list[str] = []
        with tempfile.TemporaryDirectory() as folder:
            if source is not None:
                shutil.copy(source, folder)
            run_commands(commands, Path(folder))
            for picture in self.arguments[0].split():
                name = kept_as(self.env.docname, picture)
                shutil.copy(Path(folder) / picture, kept / name)
                names.append(name)
        return names


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_directive("picture", PictureDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
