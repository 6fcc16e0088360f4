"""What all tests share: where ERCLUTCH_NO_SKIP=1 is set, a test that cannot run is a failure."""

from __future__ import annotations

import os
from collections.abc import Generator
from typing import Any

import pytest


def _strict() -> bool:
    return os.environ.get("ERCLUTCH_NO_SKIP") == "1"


def _fail(report: Any) -> None:
    """Turn a skip into a failure. An expected failure is no skip."""
    if not report.skipped or hasattr(report, "wasxfail"):
        return
    reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    report.outcome = "failed"
    report.longrepr = f"ERCLUTCH_NO_SKIP=1 allows no skip: {reason}"


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Generator[None, Any, Any]:
    report = yield
    if _strict():
        _fail(report)
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> Generator[None, Any, Any]:
    report = yield
    if _strict():
        _fail(report)
    return report
