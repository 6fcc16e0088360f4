"""Python calls a compiled model by ctypes alone. Exports carry a copy of this file, so it imports nothing of erclutch.

model = CompiledModel("libmodel.so")
effort = model.step(0.2, 0.0, 12.0, 3.0)    # one number an input; state and flags are kept in model
field = model.inverse((0.0, 0.0, 12.0, 3.0), wanted=0.5)
"""

from __future__ import annotations

import ctypes
from array import array
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, cast

#: Bits of `CompiledModel.flags`.
OUTSIDE_RANGE = 1
NON_FINITE = 2
BOTH_FIELDS = 4
LIMITED = 8
OUT_OF_REACH = 16
WIDE_BAND = 32
DRIFT = 64
ADAPTED = 128
_ABI = 1
_METH_FASTCALL = 0x80


class _Call(ctypes.Structure):
    _fields_ = (
        ("step", ctypes.c_void_p),
        ("state", ctypes.c_void_p),
        ("inputs", ctypes.c_uint32),
        ("flags", ctypes.c_uint32),
    )


class _Address(int):
    """Where a call's numbers lie, and what must stay in memory with them."""

    held: tuple[object, ...]


class _Method(ctypes.Structure):
    _fields_ = (
        ("name", ctypes.c_char_p),
        ("function", ctypes.c_void_p),
        ("flags", ctypes.c_int),
        ("doc", ctypes.c_char_p),
    )


class CompiledModel:
    """A model compiled from its exported C.

    Args:
        library: the shared library with the model ABI.
        call: the library that makes a step a function of Python; None calls through ctypes, about a microsecond slower.

    Attributes:
        step: ``step(*inputs) -> effort``: one sample, in the model's units; sets `flags`.
        name: of the model.
        digest: SHA-256 of the model.
        inputs: number of inputs.

    Raises:
        OSError: no such library, or it is no compiled model of this ABI.
    """

    step: Callable[..., float]

    def __init__(self, library: str | Path, call: str | Path | None = None) -> None:
        self._library = ctypes.CDLL(str(library))
        try:
            version = int(self._library.erc_model_abi())
        except AttributeError as error:
            raise OSError(f"{library} is no compiled model of this version: {error}") from error
        if version != _ABI:
            raise OSError(f"{library} has model ABI {version}; this version loads {_ABI}")
        # A library of an earlier version does not tell.
        exact = getattr(self._library, "erc_model_exact", None)
        if exact is not None and not exact():
            raise OSError(
                f"the compiler of {library} changed the order or the rounding of its sums and products"
            )
        for name in ("digest", "name"):
            getattr(self._library, f"erc_model_{name}").restype = ctypes.c_char_p
        self.name = cast(bytes, self._library.erc_model_name()).decode()
        self.digest = cast(bytes, self._library.erc_model_digest()).decode()
        self.inputs = int(self._library.erc_model_inputs())
        self._prepare()
        self.step = self._slow_step if call is None else self._fast_step(call)
        self.reset()

    def _prepare(self) -> None:
        number, pointer = ctypes.c_double, ctypes.c_void_p
        size = int(self._library.erc_model_state_size())
        self._memory = ctypes.create_string_buffer(size + 16)
        address = ctypes.addressof(self._memory)
        self._state = pointer(address + (-address) % 16)
        self._in, self._out = (number * self.inputs)(), number()
        signatures: dict[str, tuple[Any, ...]] = {
            "reset": (pointer,),
            "step": (pointer, pointer, pointer),
            "steady": (pointer, pointer),
            "inverse": (pointer, number, pointer),
            "inverse_now": (pointer, pointer, number, pointer),
            "run": (pointer, ctypes.c_size_t, pointer, pointer, pointer),
        }
        for name, signature in signatures.items():
            function: Any = getattr(self._library, f"erc_model_{name}")
            function.argtypes = signature
            function.restype = None if name in ("reset", "run") else ctypes.c_uint32
        step = ctypes.cast(self._library.erc_model_step, pointer).value
        self._call = _Call(step, self._state.value, self.inputs, 0)

    def _fast_step(self, call: str | Path) -> Callable[..., float]:
        """The step as a builtin function of the interpreter, around the state."""
        self._glue = ctypes.PyDLL(str(call))
        function = ctypes.cast(self._glue.erc_python_step, ctypes.c_void_p).value
        self._method = _Method(
            b"step", function, _METH_FASTCALL, b"One sample: the inputs in, the effort out."
        )
        make = ctypes.pythonapi.PyCFunction_NewEx
        make.argtypes, make.restype = (
            (ctypes.POINTER(_Method), ctypes.py_object, ctypes.c_void_p),
            ctypes.py_object,
        )
        # The function may outlive this object, so it holds on to everything that it points to.
        address = _Address(ctypes.addressof(self._call))
        address.held = (self._call, self._method, self._memory, self._library, self._glue)
        return make(ctypes.byref(self._method), address, None)

    def _slow_step(self, *inputs: float) -> float:
        self._set(inputs)
        self._call.flags = self._library.erc_model_step(
            self._state, self._in, ctypes.byref(self._out)
        )
        return self._out.value

    def _set(self, inputs: Sequence[float]) -> None:
        if len(inputs) != self.inputs:
            raise TypeError(f"{len(inputs)} numbers for the {self.inputs} inputs of {self.name}")
        self._in[:] = inputs

    @property
    def flags(self) -> int:
        """Flags of the last call."""
        return int(self._call.flags)

    def reset(self) -> None:
        """Forget all earlier samples."""
        self._library.erc_model_reset(self._state)
        self._call.flags = 0

    def use_residual(self, on: bool) -> None:
        """Whether the network on a law's residual adds to the effort of a step; after a reset it does.

        Raises:
            TypeError: the model has no such network.
        """
        switch = getattr(self._library, "erc_model_use_residual", None)
        if switch is None:
            raise TypeError(f"{self.name} has no network on the residual of a law")
        switch.argtypes, switch.restype = (ctypes.c_void_p, ctypes.c_uint32), None
        switch(self._state, int(on))

    @property
    def band(self) -> tuple[float, float]:
        """Low and high end of the band around the effort of the last step.

        Raises:
            TypeError: the model was exported without alarms.
        """
        ask = getattr(self._library, "erc_model_band", None)
        if ask is None:
            raise TypeError(f"{self.name} was exported without alarms")
        ends = (ctypes.c_double * 2)()
        ask.argtypes, ask.restype = (ctypes.c_void_p, ctypes.c_void_p), None
        ask(self._state, ends)
        return ends[0], ends[1]

    def steady(self, inputs: Sequence[float]) -> float:
        """The effort once the fluid has settled; takes speeds, leaves the state alone."""
        self._set(inputs)
        self._call.flags = self._library.erc_model_steady(self._in, ctypes.byref(self._out))
        return self._out.value

    def inverse(self, inputs: Sequence[float], wanted: float) -> float:
        """The signed field (E1 - E2 of a coaxial pair) for a wanted effort; the fields in the inputs do not matter."""
        self._set(inputs)
        self._call.flags = self._library.erc_model_inverse(
            self._in, wanted, ctypes.byref(self._out)
        )
        return self._out.value

    def inverse_now(self, inputs: Sequence[float], wanted: float) -> float:
        """The signed field that makes the effort of the next step the wanted one; the state stays as it is.

        Out of reach (a bit of `flags`) the field is the nearest end of the range. The fields in the inputs do not
        matter; positions go in where the step takes positions.
        """
        self._set(inputs)
        self._call.flags = self._library.erc_model_inverse_now(
            self._state, self._in, wanted, ctypes.byref(self._out)
        )
        return self._out.value

    def run(self, rows: Any) -> tuple[Any, Any]:
        """Many steps in one call.

        Args:
            rows: C-contiguous float64 buffer of n times `inputs` numbers, for example a NumPy array (n, inputs).

        Returns:
            Efforts (array of doubles, n) and flags (array of unsigned, n).
        """
        given = memoryview(rows)
        view = given.cast("B").cast("d")
        if len(view) % self.inputs or (given.ndim > 1 and len(view) != len(given) * self.inputs):
            raise TypeError(f"{len(view)} numbers are no rows of {self.inputs}")
        count = len(view) // self.inputs
        buffer = array("d", view)
        effort, flags = array("d", bytes(8 * count)), array("I", bytes(4 * count))
        addresses = [a.buffer_info()[0] for a in (buffer, effort, flags)]
        self._library.erc_model_run(self._state, count, *addresses)
        self._call.flags = flags[-1] if count else 0
        return effort, flags
