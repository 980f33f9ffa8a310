"""Who looks on at an environment, to show it."""

from __future__ import annotations

from typing import Any

from threewe._core import TopView
from threewe.gym.batch import Batch


class Onlooker:
    """Looks on, and keeps the ways that were driven. What the robots do stays the same, to the bit."""

    def __init__(self, batch: Batch[Any]) -> None:
        self._batch = batch
        self.ways: list[list[tuple[float, float]]] = []  # [m] of each robot

    def begin(self) -> None:
        """An episode has begun."""
        self.ways = []
        self.look()

    def look(self) -> TopView:
        """A step is over."""
        view: TopView = self._batch.core.top_view(0)
        self.ways = self.ways or [[] for _ in view.robots]
        for way, pose in zip(self.ways, view.robots, strict=True):
            way.append((pose.x, pose.y))
        return view

    def render(self) -> Any:
        """What the environment's `render` returns."""
        raise NotImplementedError

    def close(self) -> None:
        """Nothing more will be seen."""
