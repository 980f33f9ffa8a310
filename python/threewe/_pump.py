"""Robot time runs when the program waits for it: the one place where the event loop and the worlds meet.

There is one pump per event loop, shared by all worlds on it. While some task waits for robot time the pump takes turns
on the loop, and each of its turns is one of these:

    something else is ready to run      let it run first
    a wait is done                      resume who waits for it, by (deadline, creation)
    worlds have pending waits, no hold  run them, for at most 10 ms of wall time, with the GIL released
    none of these                       rest, until `wake` is called

So a tick starts only when the program has nothing left to do at the present robot time, and the same program sees the
same robot times whatever the machine is busy with. Several worlds on a loop run in rounds, one tick each, in the order
in which they were attached.

Whether something is ready is not for a callback to know by asyncio's public interface, hence `loop._ready`: the only
private name that 3we touches, and this is the only file that does.
"""

from __future__ import annotations

import asyncio
import logging
import threading
import time
import types
from collections.abc import Callable, Collection
from typing import Any, NamedTuple, Protocol

from threewe.errors import ConnectionError

logger = logging.getLogger("threewe")

SLICE = 0.010
"""[wall s] that the loop's thread ticks before other callbacks, signals and sockets have their turn."""
SHORTEST_BEAT = 0.005
"""[wall s] between two looks at whether a tick of a world in real time is due."""
TURNS_WITHOUT_TICK = 1000
"""Turns in a row that find something else ready, after which the likely mistake is reported."""
TURNS_ON_OTHER_LOOPS = 100
"""Turns that a loop without `_ready` is given to do everything else."""


class Wait(Protocol):
    """Something that becomes true at a tick."""

    @property
    def done(self) -> bool: ...
    @property
    def deadline(self) -> float: ...


class World(Protocol):
    """What the pump needs of a world."""

    def run(self, wall: float, /) -> bool: ...
    def tick(self) -> None: ...
    def take_finished(self) -> list[Any]: ...
    def has_pending(self) -> bool: ...
    def forget(self, wait: Any, /) -> None: ...
    @property
    def held(self) -> bool: ...
    @property
    def realtime(self) -> bool: ...
    def due(self) -> float: ...


Resume = Callable[[Exception | None], None]
"""Called once when a wait is done, with an error when its world broke down."""


class Watched(NamedTuple):
    """A wait with a waiter."""

    creation: int
    world: World
    resume: Resume


class Pump:
    """Ticks the worlds of one event loop. All methods are called on that loop's thread."""

    def __init__(self, loop: asyncio.AbstractEventLoop, ready: Collection[object] | None) -> None:
        """`ready` holds the loop's callbacks that are ready to run; None when the loop does not tell."""
        self._loop = loop
        self._ready = ready
        self._worlds: list[World] = []
        self._beats: dict[World, asyncio.TimerHandle] = {}
        self._watched: dict[Wait, Watched] = {}
        self._finished: list[Wait] = []
        self._created = 0
        self._scheduled = False
        self._busy_turns = 0
        if ready is None:
            logger.warning("this event loop does not tell when it is idle: robot times may differ from run to run")

    def attach(self, world: World) -> None:
        """Robot time of `world` runs from now on."""
        if world not in self._worlds:
            self._worlds.append(world)
            if world.realtime:
                self._beat(world)
        self.wake()

    def detach(self, world: World, error: Exception | None = None) -> None:
        """Robot time of `world` stands still from now on; a caller that still waits for it gets the error."""
        self._resume_finished()
        if world in self._worlds:
            self._worlds.remove(world)
        if beat := self._beats.pop(world, None):
            beat.cancel()
        for wait, entry in list(self._watched.items()):
            if entry.world is world:
                self.unwatch(wait)
                entry.resume(error or ConnectionError("disconnected while waiting for robot time"))

    async def wait(self, world: World, *waits: Wait) -> None:
        """Returns when one of the waits is done; the others are forgotten, and all of them when cancelled."""
        future = self._loop.create_future()

        def resume(error: Exception | None) -> None:
            if not future.done():
                if error:
                    future.set_exception(error)
                else:
                    future.set_result(None)

        for wait in waits:
            self.watch(world, wait, resume)
        try:
            await future
        finally:
            for wait in waits:
                self.unwatch(wait)

    def watch(self, world: World, wait: Wait, resume: Resume) -> None:
        """Calls `resume` when the wait is done."""
        if world not in self._worlds:
            raise ConnectionError("this world is not connected to the running event loop")
        self._created += 1
        self._watched[wait] = Watched(self._created, world, resume)
        self.wake()

    def unwatch(self, wait: Wait) -> None:
        """Forgets a wait; does nothing when it was done."""
        if entry := self._watched.pop(wait, None):
            entry.world.forget(wait)

    def wake(self) -> None:
        """Something has changed for which time may run or a wait may be done."""
        if not self._scheduled:
            self._scheduled = True
            self._loop.call_soon(self._turn)

    def _turn(self) -> None:
        self._scheduled = False
        if self._something_is_ready():
            self.wake()
        else:
            ran = True
            try:
                ran = self._collect_finished() or self._run_slice()
            finally:  # also when an observer raised SystemExit: the loop may be run again
                if ran:
                    self._resume_finished()
                    self.wake()

    def _something_is_ready(self) -> bool:
        self._busy_turns += 1
        if self._ready is None:
            ready = self._busy_turns <= TURNS_ON_OTHER_LOOPS
        else:
            ready = len(self._ready) > 0
            if ready and self._busy_turns == TURNS_WITHOUT_TICK:
                _report_spinning_tasks()
        if not ready:
            self._busy_turns = 0
        return ready

    def _run_slice(self) -> bool:
        """Runs the worlds whose time may run; false when there are none."""
        worlds = [world for world in self._worlds if not world.realtime and not world.held and world.has_pending()]
        if len(worlds) == 1:
            self._guard(worlds[0], lambda world: world.run(SLICE))
        elif worlds:
            self._run_rounds(worlds)
        return bool(worlds)

    def _run_rounds(self, worlds: list[World]) -> None:
        """Rounds of one tick each, until a wait is done, a world breaks down, or the slice is used up."""
        end = time.perf_counter() + SLICE
        while True:
            healthy = [self._guard(world, lambda world: world.tick()) for world in worlds]
            if self._collect_finished() or not all(healthy) or time.perf_counter() >= end:
                return

    def _guard(self, world: World, advance: Callable[[World], object]) -> bool:
        """A world that breaks down stops; those who wait for it get the reason, and so does the log."""
        try:
            advance(world)
        except Exception as error:
            logger.error("a world stopped: %s", error)
            self.detach(world, error)
            return False
        return True

    def _collect_finished(self) -> bool:
        done = (wait for world in self._worlds for wait in world.take_finished())
        self._finished += [wait for wait in done if wait in self._watched]
        return bool(self._finished)

    def _resume_finished(self) -> None:
        self._collect_finished()
        finished, self._finished = self._finished, []
        for wait in sorted(finished, key=self._order):
            if entry := self._watched.pop(wait, None):
                entry.resume(None)

    def _order(self, wait: Wait) -> tuple[float, int]:
        entry = self._watched.get(wait)
        return wait.deadline, entry.creation if entry else 0

    def _beat(self, world: World) -> None:
        """Time of this world goes by on its own: one tick whenever one is due, unless a hold is open."""
        try:
            if not world.held and world.due() <= 0.0 and self._guard(world, lambda world: world.tick()):
                self._resume_finished()
        finally:  # also when an observer raised SystemExit: the loop may be run again
            if world in self._worlds:
                self._beats[world] = self._loop.call_later(max(world.due(), SHORTEST_BEAT), self._beat, world)


def pump_of_running_loop() -> Pump:
    """The pump of the running event loop, made on first use."""
    loop = asyncio.get_running_loop()
    with _pumps_lock:
        for other in [other for other in _pumps if other.is_closed()]:
            del _pumps[other]
        if loop not in _pumps:
            _pumps[loop] = Pump(loop, getattr(loop, "_ready", None))
        return _pumps[loop]


_pumps: dict[asyncio.AbstractEventLoop, Pump] = {}
_pumps_lock = threading.Lock()


def _report_spinning_tasks() -> None:
    spinning = sorted(task.get_name() for task in asyncio.all_tasks() if _gives_up_its_turn_only(task))
    logger.warning(
        "robot time stands still: the event loop has been busy for %d turns, %s; wait with `await robot.sleep(...)`",
        TURNS_WITHOUT_TICK,
        f"with asyncio.sleep(0) in {', '.join(spinning)}" if spinning else "with callbacks that call themselves again",
    )


def _gives_up_its_turn_only(task: asyncio.Task[Any]) -> bool:
    """True when a task awaits nothing but its next turn: what it awaits in the end is a bare `yield`."""
    inner: object = task.get_coro()
    while (awaited := getattr(inner, "cr_await", None)) is not None:
        inner = awaited
    return isinstance(inner, types.GeneratorType)
