from typing import Any

class ScalarVariable:
    name: str
    valueReference: int
    causality: str
    variability: str
    initial: str | None
    start: str | None
    unit: str | None
    description: str | None
    intervalVariability: str | None

class ModelDescription:
    guid: str
    modelName: str
    fmiVersion: str
    modelVariables: list[ScalarVariable]
    unitDefinitions: list[Any]
    coSimulation: Any
    modelExchange: Any
