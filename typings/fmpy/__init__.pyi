from os import PathLike
from typing import Any

from . import validation as validation
from .model_description import ModelDescription

__version__: str

def extract(filename: str | PathLike[str], unzipdir: str | PathLike[str] | None = ...) -> str: ...
def read_model_description(
    filename: str | PathLike[str], validate: bool = ...
) -> ModelDescription: ...
def simulate_fmu(filename: str | PathLike[str], **settings: Any) -> Any: ...  # a structured array
