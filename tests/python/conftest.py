"""Robots for the tests, and tests that are coroutines."""

from __future__ import annotations

import asyncio
import compileall
import fcntl
import inspect
import os
import re
import signal
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import pytest
import threewe


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options of ./dev: `test` installs every package, `nightly` has the time for everything."""
    parser.addoption("--complete", action="store_true", help="fail where a package is missing that a test needs")
    parser.addoption("--nightly", action="store_true", help="run the tests marked `nightly`, and no others")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "nightly: takes too long for an ordinary run; --nightly runs it")
    config.pluginmanager.register(Summary(config), "summary")
    if not hasattr(config, "workerinput"):
        # with PYTHONDONTWRITEBYTECODE every program that a test starts would compile the package anew
        compileall.compile_dir(Path(threewe.__file__).parent, quiet=1)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keeps the tests of the night, or all others."""
    nightly = config.getoption("--nightly")
    kept: list[pytest.Item] = []
    left_out: list[pytest.Item] = []
    for item in items:
        (kept if (item.get_closest_marker("nightly") is not None) == nightly else left_out).append(item)
    items[:] = kept
    config.hook.pytest_deselected(items=left_out)
    summary = config.pluginmanager.get_plugin("summary")
    assert isinstance(summary, Summary)
    summary.left_out = 0 if nightly else len(left_out)
    if hasattr(config, "workeroutput"):
        config.workeroutput["left_out"] = summary.left_out


class Summary:
    """Closing lines of a run: tests left to the night, tests that needed a rerun, and packages that are missing.

    A run fails where a test needed more than one rerun and, with --complete, where one was skipped for a package.
    """

    def __init__(self, config: pytest.Config) -> None:
        self.config = config
        self.left_out = 0
        self.reruns: Counter[str] = Counter()

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        """A worker of xdist says how many tests it left out; all leave out the same."""
        self.left_out = getattr(node, "workeroutput", {}).get("left_out", self.left_out)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.reruns[report.nodeid] += report.outcome == "rerun"  # of pytest-rerunfailures

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        reporter = self.config.pluginmanager.get_plugin("terminalreporter")
        if reporter is None or hasattr(self.config, "workerinput"):
            return
        if self.left_out:
            reporter.write_line(f"\ntests left to the night, which --nightly runs: {self.left_out}")
        for test, count in (+self.reruns).items():
            too_many = ", more than one" if count > 1 else ""
            reporter.write_line(f"\nreruns that {test} needed: {count}{too_many}", red=count > 1, yellow=count == 1)
        reasons = {str(report.longrepr[2]) for report in reporter.stats.get("skipped", []) if report.longrepr}
        missing = sorted(filter(MISSING_PACKAGE.search, reasons)) if self.config.getoption("--complete") else []
        if missing:
            reporter.write_line("\nmissing packages: " + "; ".join(missing), red=True)
        if missing or max(self.reruns.values(), default=0) > 1:
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


@pytest.fixture(scope="module")
def only_cluster() -> Iterator[None]:
    """One Ray cluster at a time on this machine: the processes of two, a dozen each, starve one another."""
    with pytest.MonkeyPatch.context() as patch, Path(tempfile.gettempdir(), "threewe-ray.lock").open("w") as file:
        patch.setenv("RAY_USAGE_STATS_ENABLED", "0")
        patch.setenv("RAY_worker_niceness", "0")  # on a busy machine they waited for all others
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
