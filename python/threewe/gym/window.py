"""An environment in the Rerun viewer, at the pace of the clock."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from threewe._core import Pose2D, TopView
from threewe._extras import needed_for
from threewe.gym.batch import Batch
from threewe.gym.onlooker import Onlooker
from threewe.gym.picture import GOAL_RADIUS

with needed_for('render_mode="human"', "viz"):
    import rerun as rr

    from threewe import _viewer_layout as layout
    from threewe import _viewer_scene as solids
    from threewe import _viewer_sinks as sinks
    from threewe import drawing as d


def default_sink() -> str:
    """A window; where there is no display, a page for browsers, whose address is printed."""
    return "rerun" if sinks.has_display() else "web"


class Window(Onlooker):
    """Streams an environment to Rerun, no faster than the clock. `where` is as of `Robot(viewer=...)`."""

    def __init__(self, batch: Batch[Any], where: str) -> None:
        super().__init__(batch)
        self._where = where
        self._recording: rr.RecordingStream | None = None
        self._period = 1.0 / batch.options["control_rate"]
        self._steps = 0
        self._next = 0.0

    def begin(self) -> None:
        """Draws the episode's scene, and opens the viewer the first time."""
        scene = self._batch.scenes[self._batch.core.episode(0).scene]
        if self._recording is None:
            self._recording = sinks.open_recording(self._where, layout.stage(scene))
        self._recording.set_time(layout.TIMELINE, duration=self._steps * self._period)
        self._recording.log("scene", rr.Clear(recursive=True))
        for entity, solid in solids.scene_solids(scene):
            self._recording.log(f"scene/{entity}", solid)
        super().begin()

    def look(self) -> TopView:
        """Draws what has changed, and waits for the clock."""
        view = super().look()
        if self._recording is None:  # closed
            return view
        self._recording.set_time(layout.TIMELINE, duration=self._steps * self._period)
        for i in range(len(view.robots)):
            self._draw_robot(i, view)
        self._draw_goals(view)
        self._draw_people(view)
        self._steps += 1
        self._wait()
        return view

    def render(self) -> None:
        """Nothing: steps and resets are shown as they happen."""

    def close(self) -> None:
        """Ends the recording; a window stays, and so does a page, until Python ends."""
        if self._recording is None:
            return
        self._recording.flush()
        if self._where != "web":
            self._recording.disconnect()
        self._recording = None

    def _draw_robot(self, i: int, view: TopView) -> None:
        """Body, way and what its lidar hits."""
        color, way = d.team_color(i), [(x, y, 0.03) for x, y in self.ways[i]]
        if self._is_first_look():
            self._log(f"robot_{i}", solids.body_mesh(self._batch.hardware, color))
        self._log(f"robot_{i}", solids.transform(view.robots[i]))
        self._log(f"way_{i}", rr.LineStrips3D([way], colors=[color], radii=0.03))
        points = np.array([(x, y, self._lidar_height()) for x, y in view.hits[i]]).reshape(-1, 3)
        self._log(f"hits_{i}", rr.Points3D(points, colors=[solids.SCAN_COLOR], radii=0.03))

    def _draw_goals(self, view: TopView) -> None:
        n = len(view.goals)
        discs = rr.Cylinders3D(
            lengths=[0.02] * n,
            radii=[GOAL_RADIUS] * n,
            centers=[(x, y, 0.01) for x, y in view.goals],
            colors=[d.PLAN],
            fill_mode=solids.SOLID,
        )
        self._log("goals", discs)

    def _draw_people(self, view: TopView) -> None:
        for i, (x, y, radius) in enumerate(view.people):
            if self._is_first_look():
                self._log(f"person_{i}", solids.figure(radius))
            self._log(f"person_{i}", solids.transform(Pose2D(x, y)))

    def _log(self, entity: str, what: rr.AsComponents) -> None:
        assert self._recording is not None
        self._recording.log(f"scene/{entity}", what)

    def _is_first_look(self) -> bool:
        return len(self.ways[0]) == 1

    def _lidar_height(self) -> float:
        lidar = self._batch.hardware.lidar
        return lidar.height if lidar else 0.0

    def _wait(self) -> None:
        now = time.monotonic()
        self._next = max(self._next, now)
        time.sleep(self._next - now)
        self._next += self._period
