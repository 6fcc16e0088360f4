from collections.abc import Mapping, Sequence
from typing import Any

__version__: str

class SessionOptions:
    intra_op_num_threads: int
    inter_op_num_threads: int

class NodeArg:
    name: str
    shape: list[int]
    type: str

class InferenceSession:
    def __init__(
        self,
        path_or_bytes: str | bytes,
        sess_options: SessionOptions | None = ...,
        providers: Sequence[str] | None = ...,
    ) -> None: ...
    def get_inputs(self) -> list[NodeArg]: ...
    def get_outputs(self) -> list[NodeArg]: ...
    def run(
        self, output_names: Sequence[str] | None, input_feed: Mapping[str, Any]
    ) -> list[Any]: ...  # arrays
