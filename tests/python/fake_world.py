"""A world with nothing in it but time, in a few lines: the oracle of what the pump asks of a real one."""

from __future__ import annotations

import random
import time
from dataclasses import dataclass

PERIOD = 20_000_000  # [ns]


@dataclass(eq=False)
class FakeWait:
    due: int  # [ns]
    creation: int
    pending: bool = True  # time runs for its sake
    done: bool = False
    motion: bool = False
    cancelled: bool = False
    progress: str = "under way"
    world: FakeWorld | None = None

    @property
    def deadline(self) -> float:
        return self.due * 1e-9

    def cancel(self) -> None:
        if not self.done:
            assert self.world is not None
            self.cancelled = True
            self.due = self.world.time
            self.world.end(self)


class FakeWorld:
    realtime = False

    def __init__(self, interruptions: random.Random | None = None, *, breaks_at: float = float("inf")) -> None:
        """`interruptions` ends slices early, as a busy machine would; at `breaks_at` seconds every tick raises."""
        self.time = 0
        self.ticks = 0
        self._waits: list[FakeWait] = []
        self._finished: list[FakeWait] = []
        self._holds = 0
        self._created = 0
        self._interruptions = interruptions
        self._breaks_at = breaks_at
        self.disconnected = False

    @property
    def now(self) -> float:
        return self.time * 1e-9

    @property
    def held(self) -> bool:
        return self._holds > 0

    def due(self) -> float:
        return 0.0

    def tick(self) -> None:
        assert not self.held
        if self.now >= self._breaks_at:
            raise OSError("the fake world broke down")
        self.time += PERIOD
        self.ticks += 1
        for wait in [wait for wait in self._waits if wait.due <= self.time]:
            self.end(wait)

    def run(self, wall: float) -> bool:
        end = time.perf_counter() + wall
        while self.has_pending() and not self.held and not self._finished and time.perf_counter() < end:
            self.tick()
            if self._interruptions and self._interruptions.random() < 0.3:
                break
        return bool(self._finished)

    def end(self, wait: FakeWait) -> None:
        wait.done = True
        self._waits.remove(wait)
        self._finished.append(wait)

    def take_finished(self) -> list[FakeWait]:
        finished, self._finished = self._finished, []
        return sorted(finished, key=lambda wait: (wait.due, wait.creation))

    def has_pending(self) -> bool:
        return any(wait.pending for wait in self._waits)

    def forget(self, wait: FakeWait) -> None:
        if wait in self._waits and not wait.motion:
            self._waits.remove(wait)

    def sleep(self, seconds: float, *, pending: bool = True) -> FakeWait:
        self._created += 1
        wait = FakeWait(self.time + round(seconds * 1e9), self._created, pending, world=self)
        self._waits.append(wait)
        if wait.due <= self.time:
            self.end(wait)
        return wait

    def alarm(self, seconds: float) -> FakeWait:
        return self.sleep(seconds, pending=False)

    def motion(self, seconds: float) -> FakeWait:
        wait = self.sleep(seconds)
        wait.motion = True
        return wait

    def open_hold(self) -> None:
        self._holds += 1

    def close_hold(self, charge: float) -> FakeWait:
        self._holds -= 1
        return self.sleep(charge)

    def disconnect(self) -> None:
        self.disconnected = True

    def claim_thread(self) -> None:
        """Its time is asked for by one thread anyway."""

    def release_thread(self) -> None:
        """Likewise."""
