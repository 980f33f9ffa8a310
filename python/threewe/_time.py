"""Robot time as a program sees it: `sleep`, `timeout`, `thinking`, and waiting for motions."""

from __future__ import annotations

import asyncio
import threading
import time
import warnings
import weakref
from collections.abc import Callable
from contextvars import ContextVar
from types import TracebackType
from typing import Any, Protocol, Self

from threewe._arguments import as_seconds
from threewe._pump import Pump, Wait, World, pump_of_running_loop
from threewe.errors import ConnectionError, ContractError, TimeoutError

PROGRESS_PERIOD = 0.1
"""[s] of robot time between two calls of an `on_progress`."""


class LockstepWorld(World, Protocol):
    """What robot time needs of a world."""

    @property
    def now(self) -> float: ...
    def sleep(self, seconds: float, /) -> Any: ...
    def alarm(self, seconds: float, /) -> Any: ...
    def open_hold(self) -> None: ...
    def close_hold(self, charge: float, /) -> Any: ...
    def disconnect(self) -> None: ...
    def claim_thread(self) -> None: ...
    def release_thread(self) -> None: ...


class Motion(Wait, Protocol):
    """What robot time needs of a motion."""

    @property
    def progress(self) -> Any: ...
    def cancel(self) -> None: ...


class RobotTime:
    """Robot time of one world, for the event loop and the thread that the world is connected on."""

    def __init__(self, world: LockstepWorld) -> None:
        """Time stands still until `start`."""
        self._world = world
        self._pump: Pump | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread = 0
        self._dropped: weakref.finalize[..., RobotTime] | None = None
        self.thoughts: set[object] = set()

    def start(self) -> None:
        """Binds the world to the running event loop; robot time runs while a coroutine waits for it."""
        loop = asyncio.get_running_loop()
        if self._loop is not None and self._loop is not loop and not self._loop.is_closed():
            raise ConnectionError("this world is connected on another event loop; disconnect it there first")
        if self._loop is not loop:
            self._world.release_thread()
        self._world.claim_thread()
        self._loop, self._thread, self._pump = loop, threading.get_ident(), pump_of_running_loop()
        self._pump.attach(self._world)
        if self._dropped is not None:
            self._dropped.detach()
        self._dropped = weakref.finalize(self, _let_go, loop, self._pump, self._world)
        self._dropped.atexit = False

    def stop(self) -> None:
        """Robot time stands still; those who wait for it get a ConnectionError."""
        if self._dropped is not None:
            self._dropped.detach()
        if self._pump is not None and self._loop is not None and not self._loop.is_closed():
            self._pump.detach(self._world)
        self._pump = self._loop = None
        self._world.release_thread()

    @property
    def now(self) -> float:
        """[s] since the world began."""
        return self._world.now

    @property
    def loop(self) -> asyncio.AbstractEventLoop | None:
        """The event loop that the world is connected on."""
        return self._loop

    def on_own_thread(self) -> bool:
        """True on the thread whose event loop ticks the world."""
        return threading.get_ident() == self._thread

    @property
    def elsewhere(self) -> bool:
        """True on any other thread, while the world is connected."""
        return self._pump is not None and not self.on_own_thread()

    def check_thread(self) -> None:
        """Raises ContractError on any thread but the one whose event loop ticks the world; so does the world itself."""
        if self.elsewhere:
            raise ContractError(
                "a robot may be used on the thread of its event loop only; from other threads use "
                "loop.call_soon_threadsafe(...), asyncio.run_coroutine_threadsafe(...) or threewe.sync.Robot"
            )

    def check_waiting(self) -> Pump:
        """Raises for what could only be waited for in vain, and gives the pump to wait with."""
        pump = self._running_pump()
        if self.thoughts.isdisjoint(_inside.get()):
            return pump
        raise ContractError(
            "robot time stands still inside `thinking`: wait for the robot after the block, "
            "or in a task that was made before it"
        )

    def wake(self) -> None:
        """Something was called that may end a wait."""
        if self._pump is not None:
            self._pump.wake()

    async def wait(self, *waits: Wait) -> None:
        """Returns when one of the waits is done."""
        if not any(wait.done for wait in waits):
            await self.check_waiting().wait(self._world, *waits)

    async def wait_for_motion(self, motion: Motion, on_progress: Callable[[Any], object] | None = None) -> None:
        """Returns when the motion has ended. When the waiting task is cancelled, or `on_progress` raises, so is it."""
        try:
            while not motion.done:
                if on_progress is None:
                    await self.wait(motion)
                else:
                    await self.wait(motion, self._world.alarm(PROGRESS_PERIOD))
                    on_progress(motion.progress)
        finally:
            motion.cancel()

    async def sleep(self, seconds: float) -> None:
        """Lets `seconds` of robot time go by; 0 gives every other task that is ready its turn."""
        self.check_waiting()
        await self._wait_or_yield(self._world.sleep(as_seconds("seconds", seconds)))

    def timeout(self, seconds: float) -> Timeout:
        """Limits what happens inside to `seconds` of robot time."""
        return Timeout(self, seconds)

    def thinking(self, seconds: float | None = None) -> Thinking:
        """Robot time stands still inside; then `seconds` of it go by, or as many as the wall clock counted."""
        return Thinking(self, seconds)

    async def _wait_or_yield(self, wait: Wait) -> None:
        if wait.done:
            await asyncio.sleep(0)
        else:
            await self.wait(wait)

    def _running_pump(self) -> Pump:
        if self._pump is None:
            raise ConnectionError("not connected: use `async with Robot(...) as robot:` or `await robot.connect()`")
        self.check_thread()
        return self._pump


def _let_go(loop: asyncio.AbstractEventLoop, pump: Pump, world: LockstepWorld) -> None:
    """This world cannot be reached any more, and yet was not disconnected. Called on whichever thread noticed."""

    def release() -> None:
        pump.detach(world)
        world.release_thread()
        world.disconnect()

    try:
        loop.call_soon_threadsafe(release)
    except RuntimeError:  # the loop is closed: nothing happens on its thread any more
        release()
    warnings.warn(
        "a robot was dropped while it was connected, and so it was stopped: "
        "use `async with Robot(...) as robot:` or `await robot.disconnect()`",
        ResourceWarning,
        stacklevel=1,
    )


class InRobotTime:
    """What a robot and a world share: the time of their world."""

    _time: RobotTime

    @property
    def now(self) -> float:
        """Robot time [s]."""
        return self._time.now

    async def sleep(self, seconds: float) -> None:
        """Lets `seconds` of robot time go by."""
        await self._time.sleep(seconds)

    def timeout(self, seconds: float) -> Timeout:
        """`async with robot.timeout(seconds):` raises TimeoutError after `seconds` of robot time.

        It counts the time that goes by: what is left when a simulation is reset is left after that.
        """
        return self._time.timeout(seconds)

    def thinking(self, seconds: float | None = None) -> Thinking:
        """`async with robot.thinking(seconds=x):` for waits other than robot time: a model, the network, a thread.

        Robot time stands still inside, then `x` seconds of it go by; without `x` as many as the wall clock counted,
        and runs are no longer repeatable. Waiting for robot time inside raises ContractError, also in tasks made there.
        """
        return self._time.thinking(seconds)


class Timeout:
    """`async with robot.timeout(seconds):` cancels what is inside after `seconds` of robot time.

    Raises TimeoutError then. Time does not run for its sake: it limits what others wait for.
    """

    def __init__(self, robot_time: RobotTime, seconds: float) -> None:
        self._time = robot_time
        self._seconds = as_seconds("seconds", seconds)
        self._expired = False

    async def __aenter__(self) -> Self:
        pump = self._time._running_pump()
        task = asyncio.current_task()
        if task is None:
            raise ContractError("robot.timeout must be used inside a task")
        self._task, self._pump = task, pump
        self._cancelling = task.cancelling()
        self._alarm = self._time._world.alarm(self._seconds)
        if self._alarm.done:
            self._expire(None)
        else:
            pump.watch(self._time._world, self._alarm, self._expire)
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._pump.unwatch(self._alarm)
        if self._expired and self._task.uncancel() <= self._cancelling and isinstance(error, asyncio.CancelledError):
            raise TimeoutError(f"{self._seconds:g} s of robot time were not enough") from error

    @property
    def expired(self) -> bool:
        """True once the time was up."""
        return self._expired

    def _expire(self, error: Exception | None) -> None:
        if error is None:
            self._expired = True
            self._task.cancel()


class Thinking:
    """`async with robot.thinking(seconds=x):` for waits other than robot time: a model, the network, a thread.

    Robot time stands still inside, also for tasks that are made there. On the way out `x` seconds of it go by, as if
    the thought had taken just so long: the same in every run. Without `x` as many go by as the wall clock counted, and
    runs are no longer repeatable.
    """

    def __init__(self, robot_time: RobotTime, seconds: float | None) -> None:
        self._time = robot_time
        self._seconds = None if seconds is None else as_seconds("seconds", seconds)
        self._thought = object()

    def charge(self, seconds: float) -> None:
        """Says inside how many seconds of robot time go by on the way out."""
        self._seconds = as_seconds("seconds", seconds)

    async def __aenter__(self) -> None:
        self._time._running_pump()
        self._time._world.open_hold()
        self._time.thoughts.add(self._thought)
        self._around = _inside.get()
        _inside.set((*self._around, self._thought))
        self._began = time.perf_counter()

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        charge = self._seconds if self._seconds is not None else time.perf_counter() - self._began
        thought = self._time._world.close_hold(charge)
        self._time.thoughts.discard(self._thought)
        _inside.set(self._around)
        self._time.wake()
        try:
            if error is None:
                await self._time._wait_or_yield(thought)
        finally:
            self._time._world.forget(thought)


_inside: ContextVar[tuple[object, ...]] = ContextVar("threewe.thinking", default=())
"""The `thinking` blocks that a task is inside of, or was made inside of: some may be over by now."""
