"""Models of every kind, and the tools that `.ci/run` installs."""

from tests.support.exported_models import boards, law, models, need, network, pytest_generate_tests

__all__ = ["boards", "law", "models", "need", "network", "pytest_generate_tests"]
