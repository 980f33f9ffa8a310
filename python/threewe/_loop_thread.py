"""A thread with an event loop of its own, which lets programs without `async` wait for coroutines."""

from __future__ import annotations

import asyncio
import os
import threading
from collections.abc import Callable, Coroutine, Sequence
from typing import Any, TypeVar

from threewe.errors import ConnectionError, ContractError

R = TypeVar("R")
Work = Callable[[], Coroutine[Any, Any, R]]


class _Exit:
    """SystemExit or KeyboardInterrupt on its way to the waiting caller: raised on the loop it would end the loop."""

    def __init__(self, error: BaseException) -> None:
        self.error = error


class LoopThread:
    """A thread that runs an event loop, on which everything about one world happens."""

    def __init__(self, at_the_end: Work[None]) -> None:
        self._at_the_end = at_the_end
        self._loop = asyncio.new_event_loop()
        self._waiting: dict[asyncio.Task[Any], _Exit | None] = {}  # callers, and what ends their waiting
        self._unseen: _Exit | None = None  # what came while no caller waited
        self._collected = threading.local()
        self._process = os.getpid()
        self._thread = threading.Thread(target=self._run, name="threewe.sync", daemon=True)
        self._thread.start()

    def wait(self, work: Work[R]) -> R:
        """What the coroutine returns or raises. Ctrl-C cancels it, and with it a motion."""
        if getattr(self._collected, "wanted", False):
            raise _Collected(work)
        return self._wait(work)

    def _wait(self, work: Work[R]) -> R:
        self._check_process()
        if threading.current_thread() is self._thread:
            raise ContractError("an observer or on_progress cannot wait for robot time")
        if self._loop.is_closed():
            raise ConnectionError("Python is ending, and has disconnected this robot")
        future = asyncio.run_coroutine_threadsafe(self._until_exit(work), self._loop)
        try:
            result = future.result()
        except BaseException:
            future.cancel()
            raise
        if isinstance(result, _Exit):
            raise result.error
        return result

    def wait_together(self, calls: Sequence[Callable[[], R]]) -> list[R]:
        """What calls of `wait` return that begin at once and wait side by side."""
        works: list[Work[R]] = [self._collect(call) for call in calls]

        async def run() -> list[R]:
            async with asyncio.TaskGroup() as group:
                tasks = [group.create_task(work()) for work in works]
            return [task.result() for task in tasks]

        try:
            return self.wait(run)
        except BaseExceptionGroup as errors:
            raise errors.exceptions[0] from None

    def call(self, work: Callable[[], R]) -> R:
        """What a function returns or raises on the loop's thread."""
        self._check_process()
        if threading.current_thread() is self._thread:
            return work()

        async def run() -> R:
            return work()

        return self._wait(run)

    def close(self) -> None:
        """Ends the thread. Does nothing in a process that was forked: it has no such thread."""
        if os.getpid() != self._process:
            return
        self._loop.call_soon_threadsafe(self._loop.stop)
        if threading.current_thread() is not self._thread:
            self._thread.join()

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            while not self._ran_to_its_end():
                pass
            self._loop.run_until_complete(self._at_the_end())
        finally:
            self._loop.close()

    def _ran_to_its_end(self) -> bool:
        """False when an observer raised SystemExit or KeyboardInterrupt: all who wait for the loop get it."""
        try:
            self._loop.run_forever()
        except (SystemExit, KeyboardInterrupt) as error:
            self._unseen = None if self._waiting else _Exit(error)
            for task in self._waiting:
                self._waiting[task] = _Exit(error)
                task.cancel()
            return False
        return True

    async def _until_exit(self, work: Work[R]) -> R | _Exit:
        if self._unseen is not None:
            unseen, self._unseen = self._unseen, None
            return unseen
        task = asyncio.current_task()
        assert task is not None
        self._waiting[task] = None
        try:
            return await work()
        except (SystemExit, KeyboardInterrupt) as error:
            return _Exit(error)
        except asyncio.CancelledError:
            if (ended_by := self._waiting[task]) is None:
                raise
            return ended_by
        finally:
            del self._waiting[task]

    def _collect(self, call: Callable[[], R]) -> Work[R]:
        """The coroutine that a call would wait for."""
        self._collected.wanted = True
        try:
            call()
        except _Collected as collected:
            return collected.work
        finally:
            self._collected.wanted = False
        raise ContractError("each call must be one that waits for robot time, such as `lambda: robot.move_to(2, 1)`")

    def _check_process(self) -> None:
        if os.getpid() != self._process:
            raise ContractError(
                "this robot is of the process that made it: after a fork make a new one, "
                "or start processes with multiprocessing.get_context('spawn')"
            )


class _Collected(BaseException):
    """Ends a call that was made only to learn what it waits for."""

    def __init__(self, work: Work[Any]) -> None:
        self.work = work
