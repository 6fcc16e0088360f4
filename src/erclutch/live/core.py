"""The loop's own C core called from Python, step by step: accelerated runs and tests use what runs live."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import RunError
from erclutch.live.build import core_library
from erclutch.live.frame import FRAME
from erclutch.live.orders import Order, order_bytes
from erclutch.live.sample import COMMAND
from erclutch.live.settings import CONFIG, LoopSettings, config_of

_ABI = 1


class CompiledModel:
    """A compiled model (the interface that ``erclutch export`` writes), for the core and for Python.

    Args:
        path: shared library.

    Raises:
        RunError: it cannot be loaded, or has another interface.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        try:
            library = ctypes.CDLL(str(self.path))
            for name in ("abi", "inputs", "state_size"):
                getattr(library, f"erc_model_{name}").restype = ctypes.c_uint32
            for name in ("digest", "name"):
                getattr(library, f"erc_model_{name}").restype = ctypes.c_char_p
            abi = int(library.erc_model_abi())
            self.inputs = int(library.erc_model_inputs())
            self.digest = library.erc_model_digest().decode()
            self.name = library.erc_model_name().decode()
            size = int(library.erc_model_state_size())
            self._step, self._inverse, self._reset = (
                getattr(library, f"erc_model_{name}") for name in ("step", "inverse", "reset")
            )
        except (OSError, AttributeError, UnicodeDecodeError) as error:
            raise RunError(f"no compiled model: {error}", where=str(path), remedy="Export the model again") from error
        if abi != _ABI:
            raise RunError(f"interface {abi}, not {_ABI}", where=str(path), remedy="Export the model again")
        self._step.restype = self._inverse.restype = ctypes.c_uint32
        self._memory = np.zeros(size + 16, np.uint8)
        self._state = ctypes.c_void_p((self._memory.ctypes.data + 15) & ~15)
        self.reset()

    def reset(self) -> None:
        """As at the start."""
        self._reset(self._state)

    def step(self, inputs: Sequence[float]) -> tuple[float, int]:
        """One step: effort and flags."""
        values, effort = (ctypes.c_double * self.inputs)(*inputs), ctypes.c_double()
        flags = self._step(self._state, values, ctypes.byref(effort))
        return effort.value, int(flags)

    def inverse(self, inputs: Sequence[float], wanted: float) -> tuple[float, int]:
        """The signed field for a wanted effort, and flags."""
        values, field = (ctypes.c_double * self.inputs)(*inputs), ctypes.c_double()
        flags = self._inverse(values, ctypes.c_double(wanted), ctypes.byref(field))
        return field.value, int(flags)

    def pointers(self) -> Any:
        """``erc_model`` for the core."""
        functions = [ctypes.cast(f, ctypes.c_void_p).value for f in (self._step, self._inverse)]
        return (ctypes.c_void_p * 3)(*functions, self._state.value)


class Core:
    """The control step in C, without any input or output.

    Args:
        settings: limits, gains, programs.
        model: compiled; None estimates nothing.

    Raises:
        RunError: the settings are refused by the core.
    """

    def __init__(self, settings: LoopSettings, model: CompiledModel | None = None) -> None:
        self._library = ctypes.CDLL(str(core_library()))
        lib = self._library
        lib.erc_core_size.restype = lib.erc_core_config_size.restype = ctypes.c_uint32
        lib.erc_config_error.restype = ctypes.c_char_p
        config, self._table = config_of(settings)
        assert lib.erc_core_config_size() == CONFIG.itemsize
        error = lib.erc_config_error(config, ctypes.c_uint64(len(self._table)))
        if error is not None:
            raise RunError(error.decode(), remedy="Mend the settings")
        self._memory = np.zeros(lib.erc_core_size() // 8 + 1)
        self._model = model  # its memory must live as long as the core
        self._core = ctypes.c_void_p(self._memory.ctypes.data)
        table = ctypes.c_void_p(self._table.ctypes.data)
        lib.erc_core_init(self._core, config, table, model.pointers() if model else None)
        self._command, self._frame = np.zeros(1, COMMAND), np.zeros(1, FRAME)
        self._command_at = ctypes.c_void_p(self._command.ctypes.data)
        self._frame_at = ctypes.c_void_p(self._frame.ctypes.data)

    def step(self, samples: NDArray[Any], tick: int, *, late_ns: int = 0, events: int = 0) -> tuple[Any, Any]:
        """One step.

        Args:
            samples: what came in since the last one, dtype `erclutch.live.sample.SAMPLE`, shape (n,).
            tick: number of the deadline.
            late_ns: wake-up after it.
            events: what input and output saw.

        Returns:
            Command and frame, records that the next step overwrites. seq, times and step_ns are the caller's.
        """
        self._library.erc_core_step(
            self._core,
            ctypes.c_void_p(samples.ctypes.data),
            ctypes.c_uint32(len(samples)),
            ctypes.c_uint64(tick),
            ctypes.c_uint64(late_ns),
            ctypes.c_uint32(events),
            self._command_at,
            self._frame_at,
        )
        return self._command[0], self._frame[0]

    @property
    def memory(self) -> NDArray[np.float64]:
        """The core itself, as bytes that only C understands."""
        return self._memory

    def step_function(self) -> Any:
        """``erc_core_step`` with its argument types, for compiled callers."""
        address, word, long = ctypes.c_void_p, ctypes.c_uint32, ctypes.c_uint64
        function = self._library["erc_core_step"]  # one of its own: `step` passes what it likes
        function.argtypes, function.restype = (address, address, word, long, long, word, address, address), None
        return function

    def order(self, order: Order | int, value: float = 0.0) -> bool:
        """Give an order; whether the loop is to end."""
        return bool(self._library.erc_core_order(self._core, order_bytes(Order(order), value)))

    def stop(self) -> None:
        """Zero from now on."""
        self._library.erc_core_stop(self._core)
