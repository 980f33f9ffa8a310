"""Pictures and films: their sizes, and that what is true is drawn where it is true."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import pytest
from PIL import Image
from threewe import OccupancyGrid, Pose2D, Robot, RobotProfile, Scene, drawing
from threewe.film import GIF_SIZE, Film


async def film_of(seconds: float, folder: Path, period: float) -> int:
    async with Robot(seed=3) as robot:
        film = Film(robot, period)
        robot.set_velocity(0.3, 0.0, 0.4, hold=seconds)
        await robot.sleep(seconds)
        film.close()
        await robot.sleep(1.0)
        film.save(folder)
        return len(film.states)


def test_a_film_keeps_its_limits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import asyncio

    monkeypatch.setattr("threewe.film.VIDEO_FRAMES", 60)
    monkeypatch.setattr("threewe.film.GIF_FRAMES", 15)
    states = asyncio.run(film_of(3.0, tmp_path, 0.02))
    assert 60 < states <= 151
    with av.open(str(tmp_path / "run.mp4")) as video:
        frames = [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]
    assert len(frames) == 60
    assert np.abs(frames[0].astype(int) - frames[-1]).max() > 100
    with Image.open(tmp_path / "run.gif") as gif:
        assert gif.n_frames <= 15
    assert (tmp_path / "run.gif").stat().st_size <= GIF_SIZE
    assert (tmp_path / "map.png").exists()


def test_a_film_of_nothing_is_refused(tmp_path: Path) -> None:
    import asyncio

    async def run() -> None:
        async with Robot() as robot:
            film = Film(robot)
            with pytest.raises(ValueError, match="nothing was filmed"):
                film.save(tmp_path)

    asyncio.run(run())
    assert not list(tmp_path.iterdir())


def pixel(picture: Image.Image, view: drawing.View, x: float, y: float) -> tuple[int, ...]:
    column, row = view.point(x, y)
    color = picture.convert("RGB").getpixel((round(column), round(row)))
    assert isinstance(color, tuple)
    return tuple(int(c) for c in color)


def test_walls_are_drawn_where_they_are() -> None:
    scene = Scene.load("office_v2")
    view = drawing.View.of(scene, 800)
    picture = drawing.draw_scene(scene, view, labels=False)
    for wall in scene.walls:
        middle = (wall.a[0] + wall.b[0]) / 2, (wall.a[1] + wall.b[1]) / 2
        assert pixel(picture, view, *middle) == drawing.INK[:3]


def test_a_map_is_drawn_the_right_way_up() -> None:
    cells = np.full((40, 60), -1, np.int8)
    cells[30:, :] = 0  # high y
    cells[5:10, 40:50] = 100  # low y, high x
    grid = OccupancyGrid(cells, 0.05, (-1.0, -0.5))
    view = drawing.View((-2.0, -2.0), (3.0, 3.0), 100.0)
    picture = drawing.draw_map(grid, view)
    assert pixel(picture, view, 0.0, 1.2) == (255, 255, 255)
    assert pixel(picture, view, 1.2, -0.1) == drawing.INK[:3]
    assert pixel(picture, view, 0.0, 0.3) == drawing.UNKNOWN[:3]
    assert pixel(picture, view, -1.5, 0.0) == drawing.UNKNOWN[:3]


def test_a_robot_is_drawn_where_it_is() -> None:
    view = drawing.View((-1.0, -1.0), (1.0, 1.0), 200.0)
    picture = Image.new("RGBA", view.size, drawing.PAPER)
    drawing.draw_robot(picture, view, Pose2D(0.5, 0.5, np.pi / 2), RobotProfile.load("3we_standard_v2"))
    assert pixel(picture, view, 0.5, 0.55) == (255, 255, 255)
    assert pixel(picture, view, 0.58, 0.44) == drawing.BODY[:3]
    assert pixel(picture, view, -0.5, -0.5) == drawing.PAPER[:3]
