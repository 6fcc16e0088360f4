"""Python calls the loop's own C core step by step: accelerated runs and tests use what runs live."""

from __future__ import annotations

import ctypes
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import RunError
from erclutch.signals.array import Array
from erclutch.wings.live.c_build import loaded_core
from erclutch.wings.live.layout import COMMAND, CONFIG, FRAME
from erclutch.wings.live.orders import Order, order_bytes
from erclutch.wings.live.settings import LoopSettings, config_of


class _Model:
    """What the core needs of a compiled model: its functions and memory for its state."""

    def __init__(self, path: Path) -> None:
        try:
            library = ctypes.CDLL(str(path))
            library.erc_model_state_size.restype = ctypes.c_uint32
            size = int(library.erc_model_state_size())
            names = ("step", "inverse", "reset", "steady")
            step, inverse, back, steady = [
                ctypes.cast(library[f"erc_model_{name}"], ctypes.c_void_p).value for name in names
            ]
            reset = library.erc_model_reset
        except (OSError, AttributeError) as error:
            raise RunError(
                f"no compiled model: {error}", where=str(path), remedy="Export the model again"
            ) from error
        self._memory = np.zeros(size + 16, np.uint8)
        state = ctypes.c_void_p((self._memory.ctypes.data + 15) & ~15)
        reset(state)
        # As in ``erc_model``.
        self.pointers = (ctypes.c_void_p * 5)(step, inverse, back, state.value, steady)


@cache
def step_function() -> Any:
    """``erc_core_step`` with its argument types, for compiled callers; all cores share it."""
    function = loaded_core().erc_core_step
    function.restype = None
    function.argtypes = (
        ctypes.c_void_p,  # the core
        ctypes.c_void_p,  # samples,
        ctypes.c_uint32,  # and how many
        ctypes.c_uint64,  # number of the deadline
        ctypes.c_uint64,  # by how many ns the loop woke after it
        ctypes.c_uint32,
        ctypes.c_void_p,  # what comes out: the command,
        ctypes.c_void_p,  # and the frame
    )
    return function


class Core:
    """The control step in C, without any input or output.

    Args:
        settings: limits, gains, programs.
        model: shared library of a compiled model; None estimates nothing.

    Raises:
        SettingError: the core refuses the settings.
        RunError: the library is no model.
    """

    def __init__(self, settings: LoopSettings, model: Path | None = None) -> None:
        self._library = loaded_core()
        lib = self._library
        for function in (lib.erc_core_size, lib.erc_core_config_size, lib.erc_core_state):
            function.restype = ctypes.c_uint32
        config, self._table = config_of(settings)
        assert lib.erc_core_config_size() == CONFIG.itemsize
        self._memory = np.zeros(lib.erc_core_size() // 8 + 1)
        self._core = ctypes.c_void_p(self._memory.ctypes.data)
        table = ctypes.c_void_p(self._table.ctypes.data)
        pointers: Any = None
        if model is not None:
            self._model = _Model(model)  # its memory must live as long as the core
            pointers = self._model.pointers
        lib.erc_core_init(self._core, config, table, pointers)
        self._command = np.zeros(1, COMMAND)
        self._frame = np.zeros(1, FRAME)
        self._out = (self._command.ctypes.data, self._frame.ctypes.data)
        self._step = step_function()

    def step(
        self,
        samples: NDArray[Any],
        tick: int,
        *,
        late_ns: int = 0,
    ) -> tuple[Any, Any]:
        """One step.

        Args:
            samples: what came in since the last one, dtype `erclutch.wings.live.layout.SAMPLE`, shape (n,).
            tick: number of the deadline.
            late_ns: wake-up after it.

        Returns:
            Command and frame, records that the next step overwrites. seq, times and step_ns are the caller's.
        """
        self._step(self._core, samples.ctypes.data, len(samples), tick, late_ns, 0, *self._out)
        return self._command[0], self._frame[0]

    @property
    def state(self) -> int:
        """How it is, as `erclutch.wings.live.ring.State` numbers it."""
        return int(self._library.erc_core_state(self._core))

    @property
    def memory(self) -> Array:
        """The core itself, as bytes that only C understands."""
        return self._memory

    def order(self, order: Order | int, value: float = 0.0) -> bool:
        """Give an order; whether the loop is to end."""
        bits = order_bytes(Order(order), value)
        return bool(self._library.erc_core_order(self._core, bits))

    def stop(self) -> None:
        """Zero from now on."""
        self._library.erc_core_stop(self._core)
