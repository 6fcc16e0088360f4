"""A page plays events to the loop's own C core, which zig compiles to WebAssembly, and shows the answers.

write_explorer(Path("states.html"))
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.errors import RunError
from erclutch.export.c.compilers import Compiler
from erclutch.export.c.cross_compiler import ZIG
from erclutch.files import whole_file
from erclutch.wings.live.c_build import CORE, SOURCES, build
from erclutch.wings.live.explained_states import WAYS, Period, events_of
from erclutch.wings.live.layout import EVENT_BITS, FRAME, SAMPLE
from erclutch.wings.live.orders import order_bytes
from erclutch.wings.live.ring import State
from erclutch.wings.live.settings import REST, LoopProgram, LoopSettings, Mode, Waveform, config_of

#: What the page's core runs: a sine of the signed field, so that both clutches come on in turn.
SWING = LoopProgram("swing", Mode.FIELDS, Waveform.SINE, 0.5, 4.0)
SETTINGS = LoopSettings(programs=(SWING, REST))
_CALLED = ("size", "init", "step", "order", "state", "stop")
_WASM = ("-mexec-model=reactor", "-s", *(f"-Wl,--export=erc_core_{name}" for name in _CALLED))


def core_wasm() -> Path:
    """The loop's core as WebAssembly, without imports; compiled once, then out of the cache.

    Raises:
        CompilerError: there is no zig, or it failed.
    """
    zig = Compiler("zig for WebAssembly", (*ZIG, "cc", "-target", "wasm32-wasi"))
    return build("core.wasm", [SOURCES / name for name in CORE], libraries=(), flags=_WASM, compiler=zig)


def write_explorer(file: Path) -> None:
    """Write the page.

    Args:
        file: its name, which ends in .html.

    Raises:
        CompilerError: there is no zig, or it failed.
        RunError: another ending, or the file cannot be written.
    """
    if file.suffix != ".html":
        raise RunError("a page's name ends in .html", where=str(file), remedy="Give a name such as states.html")
    page = (Path(__file__).parent / "state_explorer.html").read_text(encoding="utf-8")
    style, script = (re.search(f"<{tag}[^>]*>(.*?)</{tag}>", page, re.DOTALL) for tag in ("style", "script"))
    assert style is not None
    assert script is not None
    allowed = f"script-src {_hash(script[1])} 'wasm-unsafe-eval'; style-src {_hash(style[1])}"
    page = page.replace("@POLICY@", f"default-src 'none'; {allowed}; base-uri 'none'; form-action 'none'")
    text = json.dumps(_data()).replace("<", "\\u003c")
    with whole_file(file) as partial:
        partial.write_text(page.replace("@DATA@", text), encoding="utf-8")


def _hash(text: str) -> str:
    return f"'sha256-{_base64(hashlib.sha256(text.encode()).digest())}'"


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode()


def _data() -> dict[str, Any]:
    def places(record: np.dtype[Any]) -> dict[str, int]:
        fields: Any = record.fields
        return {"size": record.itemsize} | {name: place for name, (_, place, *_) in fields.items()}

    def played(periods: tuple[Period, ...]) -> list[dict[str, Any]]:
        orders = [[_base64(order_bytes(*order)) for order in period.orders] for period in periods]
        return [{**asdict(p), "orders": o, "late": round(1e9 * p.late)} for p, o in zip(periods, orders, strict=True)]

    return {
        "wasm": _base64(core_wasm().read_bytes()),
        "config": _base64(config_of(SETTINGS)[0]),
        "limit": SETTINGS.field_limit,
        "sample": places(SAMPLE),
        "frame": places(FRAME),
        "bits": EVENT_BITS,
        "states": {state.value: state.name.lower() for state in State},
        "ways": {state.name.lower(): played(way) for state, way in WAYS.items()},
        "events": {event: played(periods) for event, periods in events_of(SETTINGS).items()},
    }
