from typing import Any

class FMU2Slave:
    def __init__(
        self, guid: str, unzipDirectory: str, modelIdentifier: str, instanceName: str
    ) -> None: ...
    def __getattr__(
        self, name: str
    ) -> Any: ...  # one method a function of the standard, by its name without "fmi2"
