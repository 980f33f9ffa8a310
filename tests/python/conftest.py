"""Robots for the tests, and tests that are coroutines."""

from __future__ import annotations

import asyncio
import fcntl
import inspect
import os
import re
import signal
import tempfile
from collections.abc import Iterator
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import pytest
import threewe


def pytest_addoption(parser: pytest.Parser) -> None:
    """What ./dev test asks for, since it installs every package."""
    parser.addoption("--complete", action="store_true", help="fail where a package is missing that a test needs")


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """With --complete, a test that was skipped for a package has failed."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if reporter is None or not session.config.getoption("--complete"):
        return
    reasons = {str(report.longrepr[2]) for report in reporter.stats.get("skipped", []) if report.longrepr}
    if missing := sorted(filter(MISSING_PACKAGE.search, reasons)):
        reporter.write_line("\nmissing packages: " + "; ".join(missing), red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


MISSING_PACKAGE = re.compile("is not installed|could not import|needs ")


@pytest.fixture(autouse=True, scope="session")
def no_model() -> None:
    """A model that the environment of the tests names is not asked by instructions that name none."""
    os.environ.pop("THREEWE_MODEL", None)


@pytest.fixture(autouse=True, scope="session")
def ctrl_c() -> Iterator[None]:
    """A shell starts background jobs, ./dev or pytest, deaf to Ctrl-C; the tests that send it would wait for ever."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def only_cluster(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """One Ray cluster at a time on this machine: the processes of two, a dozen each, starve one another."""
    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    monkeypatch.setenv("RAY_worker_niceness", "0")  # on a busy machine they waited for all others
    with Path(tempfile.gettempdir(), "threewe-ray.lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


@pytest.fixture(scope="session")
def the_robot() -> threewe.Robot:
    """One robot for all tests: making a world takes longer than most tests."""
    return threewe.Robot(scene="corridor_v1", noise="ideal")


@pytest.fixture
def robot(the_robot: threewe.Robot) -> threewe.Robot:
    """A holonomic robot without noise in `corridor_v1`; connected and at its start when the test is a coroutine."""
    return the_robot


@pytest.fixture(scope="session")
def the_differential_robot() -> threewe.Robot:
    return threewe.Robot(scene="corridor_v1", hardware="turtlebot_like", noise="ideal")


@pytest.fixture
def differential_robot(the_differential_robot: threewe.Robot) -> threewe.Robot:
    """The same on two driven wheels."""
    return the_differential_robot


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """Runs a test that is a coroutine, with its robots connected and at their start."""
    if not inspect.iscoroutinefunction(pyfuncitem.obj):
        return None
    arguments = {name: pyfuncitem.funcargs[name] for name in inspect.signature(pyfuncitem.obj).parameters}
    asyncio.run(_perform(pyfuncitem.obj, arguments))
    return True


async def _perform(test: Any, arguments: dict[str, Any]) -> None:
    async with AsyncExitStack() as stack:
        for robot in arguments.values():
            if isinstance(robot, threewe.Robot):
                await stack.enter_async_context(robot)
                assert robot.simulation is not None
                robot.simulation.reset()
        await test(**arguments)
