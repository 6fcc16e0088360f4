"""A package with entry points can be made for tests of the command line in this process."""

from tests.support.installed_plugin import install

__all__ = ["install"]
