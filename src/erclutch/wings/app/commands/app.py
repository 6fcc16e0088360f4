"""``erclutch app`` shows a folder of logs and runs as a page, for the whole road without a shell."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from erclutch.errors import SettingError
from erclutch.files import scratch_folder

COMMAND = {
    "help": "Show a folder of logs and runs as a page: drop a log, fit, read the report, export.",
    "panel": "The road of a log",
    "place": 2,
}


def app(
    folder: Annotated[Path, Parameter(name="FOLDER", show_default=False)] = Path(),
    /,
    *,
    port: int = 0,
    open_: Annotated[bool, Parameter(name="--open", negative=())] = False,
) -> int:
    """Show a folder of logs and runs as a page on this machine: drop a log, see it, fit, read the report, export.

    The page starts the commands of this command line and shows each. Logs, runs and exports are files of the folder;
    the page keeps nothing else. Ctrl-C ends the server and the commands that run.

    Args:
        folder: Folder of your logs and runs; it may be empty. Default: the current folder.
        port: Port on this machine; 0 takes any that is free.
        open_: Open the page in the browser.
    """
    import webbrowser

    try:
        from erclutch.wings.app.workbench_server import Workbench
        from erclutch.wings.live.page.connections import ListeningSocket, server_of
    except ImportError as error:
        raise SettingError(
            f"{error.name} is not installed", remedy='Run: pip install "erclutch[live]"'
        ) from error
    from erclutch.cli import terminal
    from erclutch.wings.live.page.access import Access, new_token

    if folder.is_file():
        raise SettingError(
            "this is a file", where=str(folder), remedy="Give the folder that it lies in"
        )
    if not folder.is_dir():
        raise SettingError(
            "there is no such folder",
            where=str(folder),
            remedy="Make it first, or give another one",
        )
    try:
        listening = ListeningSocket(port)
    except (OSError, OverflowError) as error:
        raise SettingError(
            f"port {port} cannot be had ({error})", remedy="Give another --port"
        ) from error
    access = Access(listening.port, new_token())
    with listening, scratch_folder() as scratch:
        bench = Workbench(folder, access, Path(scratch))
        server = server_of(bench.app, bench.app.strangers, ws="none")
        terminal.say(
            f"{access.url}\nOpen this address in a browser on this machine. Ctrl-C ends it."
        )
        if open_:
            webbrowser.open(access.url)
        try:
            server.run(sockets=[listening])
        except KeyboardInterrupt:
            pass  # the server ended in order, and passes the signal on
        finally:
            bench.jobs.close()
    return 0
