"""Observers of every tick of a robot."""

from __future__ import annotations

import asyncio
import itertools
import weakref
from collections.abc import Callable

from threewe._core import Runtime, TickView

Observer = Callable[[TickView], object]


class Observers:
    """The observers of one robot. One that raises is reported, once, and not called any more."""

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._observers: dict[int, Observer] = {}
        self._numbers = itertools.count(1)
        self._tap: int | None = None

    def add(self, observer: Observer) -> int:
        """A number for `remove`, which no other observer gets."""
        if self._tap is None:
            self._tap = self._runtime.observe(_tap(weakref.ref(self)))
        number = next(self._numbers)
        self._observers[number] = observer
        return number

    def remove(self, number: int) -> None:
        """Does nothing when the observer is gone already."""
        self._observers.pop(number, None)
        if not self._observers and self._tap is not None:
            self._runtime.unobserve(self._tap)
            self._tap = None

    def tell(self, tick: TickView) -> None:
        """Calls those who are still there when it is their turn."""
        for number, observer in list(self._observers.items()):
            if number not in self._observers:
                continue
            try:
                observer(tick)
            except (SystemExit, KeyboardInterrupt):  # end the program
                self.remove(number)
                raise
            except Exception as error:
                self.remove(number)
                message = f"an observer of '{self._runtime.profile.name}' failed and is not called any more"
                asyncio.get_running_loop().call_exception_handler({"message": message, "exception": error})


def _tap(observers: weakref.ref[Observers]) -> Callable[[TickView], None]:
    """What the C++ side calls. It must not keep them alive: Python's garbage collector cannot see into C++."""

    def tell(tick: TickView) -> None:
        if (alive := observers()) is not None:
            alive.tell(tick)

    return tell
