"""Programs that wait for robot time in every way give the same transcript everywhere, to the tick."""

from __future__ import annotations

import asyncio
import json
import random
import sys
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from concurrency import PROGRAMS, Transcript, perform
from fake_world import FakeWorld
from threewe import _core
from threewe._time import RobotTime

GOLDEN: dict[str, Transcript] = json.loads((Path(__file__).parent / "golden/concurrency.json").read_text())


@pytest.fixture(scope="session")
def worlds() -> list[_core.World]:
    """Three worlds for all tests: making one takes longer than any program here."""
    options = _core.RobotOptions(scene="corridor_v1", noise="ideal")
    return [_core.World(options) for _ in range(3)]


@pytest.fixture
def real_worlds(worlds: list[_core.World]) -> list[_core.World]:
    """The same at time 0."""
    for world in worlds:
        _core.Simulation(world, 0).reset()
    return worlds


def expected(name: str) -> list[tuple[float, str]]:
    if name == "eager_tasks" and sys.version_info < (3, 12):
        pytest.skip("eager tasks begin with Python 3.12")
    return [(when, event) for when, event in GOLDEN[name]]


def transcript(name: str, worlds: Sequence[FakeWorld | _core.World]) -> Transcript:
    return asyncio.run(perform(name, [RobotTime(world) for world in worlds]))


@pytest.fixture
def busy_machine() -> Iterator[None]:
    """Another Python thread that takes the GIL whenever it can."""
    done = threading.Event()

    def work() -> None:
        while not done.is_set():
            sum(range(1000))

    thread = threading.Thread(target=work)
    thread.start()
    yield
    done.set()
    thread.join()


def test_the_golden_transcripts_are_complete() -> None:
    assert list(GOLDEN) == list(PROGRAMS)


@pytest.mark.parametrize("name", PROGRAMS)
def test_in_the_fake_world(name: str) -> None:
    assert transcript(name, [FakeWorld() for _ in range(3)]) == expected(name)


@pytest.mark.parametrize("name", PROGRAMS)
def test_however_slices_end(name: str) -> None:
    for seed in range(20):
        chance = random.Random(seed)
        assert transcript(name, [FakeWorld(chance) for _ in range(3)]) == expected(name), f"seed {seed}"


@pytest.mark.parametrize("name", PROGRAMS)
def test_in_real_worlds(name: str, real_worlds: list[_core.World]) -> None:
    assert transcript(name, real_worlds) == expected(name)


@pytest.mark.parametrize("name", ["gather", "nested", "thinking", "several_worlds", "queues_events_and_locks"])
@pytest.mark.usefixtures("busy_machine")
def test_on_a_busy_machine(name: str, real_worlds: list[_core.World]) -> None:
    assert transcript(name, real_worlds) == expected(name)


@pytest.mark.parametrize("name", ["gather", "nested", "callbacks"])
def test_in_debug_mode(name: str) -> None:
    clocks = [RobotTime(FakeWorld()) for _ in range(3)]
    with asyncio.Runner(debug=True) as runner:
        assert runner.run(perform(name, clocks)) == expected(name)
