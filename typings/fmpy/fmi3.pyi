from typing import Any

class _FMU3:
    def __init__(
        self, guid: str, unzipDirectory: str, modelIdentifier: str, instanceName: str
    ) -> None: ...
    def __getattr__(
        self, name: str
    ) -> Any: ...  # one method a function of the standard, by its name without "fmi3"

class FMU3Slave(_FMU3): ...
class FMU3Model(_FMU3): ...
