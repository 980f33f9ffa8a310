"""Pictures of an environment from above."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe._core import Scene, TopView
from threewe._extras import needed_for
from threewe.gym.batch import Batch
from threewe.gym.onlooker import Onlooker

with needed_for("render_mode", "viz"):
    from PIL import Image

    from threewe import drawing as d

WIDTH = 800  # [pixels]
GOAL_RADIUS = 0.5  # [m]
VEIL = (38, 44, 56, 105)


@dataclass
class _Stage:
    """A scene without what moves: drawn once."""

    view: d.View
    picture: Image.Image
    nearest: NDArray[np.int64]  # for each cell of the ground, the one that it is seen with


class Painter(Onlooker):
    """Pictures: floors, walls, furniture and people; robots, their goals, ways and scans; what is still to be seen."""

    def __init__(self, batch: Batch[Any]) -> None:
        super().__init__(batch)
        self._stages: dict[int, _Stage] = {}  # by scene

    def render(self) -> NDArray[np.uint8]:
        """(H, W, 3) uint8 RGB."""
        seen = self._batch.core.top_view(0)
        scene = self._batch.core.episode(0).scene
        if scene not in self._stages:
            self._stages[scene] = _stage(self._batch.scenes[scene], seen)
        stage = self._stages[scene]
        view, picture = stage.view, stage.picture.copy()
        alone = len(seen.robots) == 1

        if seen.ground.size:
            _veil(picture, stage, seen, self._batch.scenes[scene])
        for pose, hits in zip(seen.robots, seen.hits, strict=True):
            d.draw_rays(picture, view, (pose.x, pose.y), hits)
        for i, way in enumerate(self.ways):
            d.draw_path(picture, view, way, d.TRAJECTORY if alone else d.team_color(i), 0.05)
        for i, goal in enumerate(seen.goals):
            d.draw_goal(picture, view, goal, GOAL_RADIUS, d.PLAN if alone else d.team_color(i))
        for x, y, radius in seen.people:
            d.draw_person(picture, view, (x, y), radius)
        for i, pose in enumerate(seen.robots):
            d.draw_robot(picture, view, pose, self._batch.hardware, d.team_color(i))
        return np.asarray(d.finish(picture))


def _stage(scene: Scene, seen: TopView) -> _Stage:
    view = d.View.of(scene, WIDTH)
    return _Stage(view, d.draw_scene(scene, view), _nearest_ground(seen.ground))


def _nearest_ground(ground: NDArray[np.uint8]) -> NDArray[np.int64]:
    """For each cell the nearest one that is to be seen: what stands there is seen with what is next to it."""
    nearest = np.where(ground.ravel() > 0, np.arange(ground.size), -1).reshape(ground.shape)
    while (nearest < 0).any() and (nearest >= 0).any():
        for lines in (nearest, nearest.T):
            for to, neighbour in ((lines[1:], lines[:-1].copy()), (lines[:-1], lines[1:].copy())):
                to[to < 0] = neighbour[to < 0]
    return nearest


def _veil(picture: Image.Image, stage: _Stage, seen: TopView, scene: Scene) -> None:
    """Darkens what is still to be seen, within the walls."""
    view = stage.view
    unseen = seen.ground.ravel()[stage.nearest] == 1
    cells = Image.fromarray(np.where(unseen[::-1], np.uint8(VEIL[3]), np.uint8(0)))
    width, height = (round(count * seen.ground_resolution * view.pixels) for count in cells.size)
    left, bottom = view.point(*seen.ground_origin)
    mask = Image.new("L", picture.size)
    mask.paste(cells.resize((width, height), Image.Resampling.BILINEAR), (round(left), round(bottom) - height))
    (x0, y1), (x1, y0) = view.point(*scene.min), view.point(*scene.max)
    box = round(x0), round(y0), round(x1), round(y1)
    picture.paste(VEIL[:3], box, mask.crop(box))
