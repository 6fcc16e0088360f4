"""Models of every kind, the tools that `.ci/run` installs, and FMUs for this machine alone."""

from tests.support.exported_models import boards, law, models, need, network, pytest_generate_tests
from tests.wings.own_machine import own_machine

__all__ = ["boards", "law", "models", "need", "network", "own_machine", "pytest_generate_tests"]
