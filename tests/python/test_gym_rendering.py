"""What environments look like: what is true is drawn where it is true, and drawing changes nothing."""

from __future__ import annotations

import importlib.util
import math
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import threewe
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray
from threewe import drawing
from threewe.gym import TASKS, Env
from threewe.gym.picture import WIDTH
from threewe.gym.window import Window

from .test_viewer import Recording

SMALL: dict[str, Any] = {"scene": [threewe.Scene.generate(1, size=(8.0, 6.0))], "max_steps": 60}
LEAN: dict[str, Any] = {**SMALL, "observations": ("pose",), "render_mode": "rgb_array"}
AHEAD = np.array([0.6, 0.0, 0.2], np.float32)


def color_at(picture: NDArray[np.uint8], scene: threewe.Scene, x: float, y: float) -> tuple[int, ...]:
    column, row = drawing.View.of(scene, WIDTH).point(x, y)
    return tuple(picture[int(row / drawing.SUPERSAMPLING), int(column / drawing.SUPERSAMPLING)].tolist())


def is_near(color: tuple[int, ...], other: tuple[int, ...], most: int = 40) -> bool:
    return all(abs(a - b) <= most for a, b in zip(color, other[:3], strict=True))


@pytest.mark.parametrize("name", TASKS)
def test_check_env_finds_nothing(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for display in ("DISPLAY", "WAYLAND_DISPLAY"):  # no windows in tests
        monkeypatch.delenv(display, raising=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(f"3we/{name}-v1", **SMALL, render_mode="rgb_array").unwrapped)


@pytest.mark.parametrize("task", TASKS.values())
def test_drawing_changes_nothing(task: str) -> None:
    drawn, bare = Env(task=task, **LEAN), Env(task=task, **{**LEAN, "render_mode": None})
    assert bare.render() is None
    for env in (drawn, bare):
        env.reset(seed=3)
    for _ in range(20):
        drawn.render()
        np.testing.assert_array_equal(drawn.step(AHEAD)[0]["pose"], bare.step(AHEAD)[0]["pose"])


def test_robot_goal_and_way_are_where_they_are() -> None:
    scene = threewe.Scene.load("office_v2")
    env = Env(task="navigation", **{**LEAN, "scene": scene, "noise": "ideal"})
    _, info = env.reset(seed=5, options={"start": (0.0, 0.0, 0.0), "goal": (2.0, 1.0)})
    picture = env.render()
    assert picture.dtype == np.uint8
    assert picture.shape[1:] == (WIDTH, 3)
    assert is_near(color_at(picture, scene, 2.0, 1.0), drawing.PLAN)  # RGB: red and blue are not the same
    wall = scene.walls[0]
    assert is_near(color_at(picture, scene, (wall.a[0] + wall.b[0]) / 2, (wall.a[1] + wall.b[1]) / 2), drawing.INK)
    for _ in range(30):
        *_, info = env.step(AHEAD)
    driven = env.render()
    assert drawing.TRAJECTORY[2] > drawing.TRAJECTORY[0]
    way = color_at(driven, scene, 0.05, 0.0)
    assert is_near(way, drawing.TRAJECTORY, 60)
    x, y, theta = info["true_pose"]
    assert math.hypot(x, y) > 0.5
    assert is_near(color_at(driven, scene, x - 0.09 * math.sin(theta), y + 0.09 * math.cos(theta)), drawing.BODY, 60)
    env.reset()
    assert not is_near(color_at(env.render(), scene, 0.05, 0.0), drawing.TRAJECTORY, 60)  # a way ends with its episode


def test_people_are_where_they_are() -> None:
    scene = threewe.Scene.load("dynamic_v1")
    env = Env(task="navigation", **{**LEAN, "scene": scene})
    env.reset(seed=1)
    before = env._core.top_view(0).people
    for _ in range(20):
        env.step(np.zeros(3, np.float32))
    people = env._core.top_view(0).people
    assert len(people) == len(scene.people)
    assert max(math.dist(a[:2], b[:2]) for a, b in zip(before, people, strict=True)) > 0.3
    picture = env.render()
    for x, y, radius in people:
        assert is_near(color_at(picture, scene, x + 0.75 * radius, y), drawing.ROUTE, 60)


def test_what_is_still_to_be_explored_is_dark() -> None:
    scene = threewe.Scene.load("office_v2")
    env = Env(task="exploration", **{**LEAN, "scene": scene})
    _, info = env.reset(seed=1)
    dark = env.render().mean()
    for _ in range(15):
        *_, info = env.step(AHEAD)
    ground = env._core.top_view(0).ground
    assert (ground == 2).sum() / (ground > 0).sum() == pytest.approx(info["coverage"])
    assert env.render().mean() > dark + 3


def test_every_scene_is_drawn_in_its_own_size() -> None:
    scenes = [threewe.Scene.generate(1, size=(8.0, 6.0)), threewe.Scene.generate(2, size=(6.0, 12.0))]
    env = Env(task="exploration", **{**LEAN, "scene": scenes})
    shapes = set()
    for scene in scenes:
        env.reset(seed=0, options={"scene": scene.name})
        shapes.add(env.render().shape)
    assert len(shapes) == 2


def test_teams_are_drawn() -> None:
    pytest.importorskip("pettingzoo", reason="not shown: pettingzoo is not installed")
    env = threewe.gym.MultiAgentEnv(task="navigation", num_robots=3, **{**LEAN, "scene": "office_v2"})
    env.reset(seed=2)
    picture = env.render()
    for i, goal in enumerate(env._core.top_view(0).goals):
        assert is_near(color_at(picture, threewe.Scene.load("office_v2"), *goal), drawing.team_color(i))


def test_gymnasium_records_videos(tmp_path: Path) -> None:
    pytest.importorskip("moviepy", reason="not shown: moviepy is not installed")
    import av

    env = gymnasium.make("3we/Navigation-v1", **{**LEAN, "max_steps": 10})
    env = gymnasium.wrappers.RecordVideo(env, str(tmp_path / "videos"), episode_trigger=lambda _: True)
    env.reset(seed=1)
    while not any(env.step(np.zeros(3, np.float32))[2:4]):
        pass
    env.close()
    (path,) = (tmp_path / "videos").glob("*.mp4")
    with av.open(str(path)) as video:
        frames = list(video.decode(video=0))
        assert video.streams.video[0].average_rate == 10
    assert len(frames) in (10, 11)
    assert frames[0].width == WIDTH


def test_a_window_shows_what_is_true(tmp_path: Path) -> None:
    env = Env(task="navigation", **{**LEAN, "render_mode": None, "control_rate": 50.0})
    window = Window(env._batch, str(tmp_path / "run.rrd"))
    env.reset(seed=3)
    window.begin()
    poses = [env._core.true_poses[0].copy()]
    for _ in range(10):
        env.step(AHEAD)
        window.look()
        poses.append(env._core.true_poses[0].copy())
    env.reset()
    window.begin()
    poses.append(env._core.true_poses[0].copy())
    assert window.render() is None
    window.close()
    window.close()
    recording = Recording(tmp_path / "run.rrd")
    rows = list(recording.rows("scene/robot_0", "Transform3D:translation"))
    np.testing.assert_allclose([time for time, _ in rows], np.arange(12) / 50)
    np.testing.assert_allclose([value[0][:2] for _, value in rows], np.array(poses)[:, :2], atol=1e-6)
    assert {"/scene/walls", "/scene/hits_0", "/scene/goals", "/scene/way_0"} <= recording.entities


@pytest.mark.parametrize(("missing", "mode"), [("PIL", "rgb_array"), ("PIL", "human"), ("rerun", "human")])
def test_what_is_missing_is_named(missing: str, mode: str) -> None:
    assert importlib.util.find_spec(missing)
    program = f"""
import sys
sys.modules[{missing!r}] = None
import threewe
try:
    threewe.gym.Env(task="exploration", scene="corridor_v1", render_mode={mode!r})
except threewe.ConfigError as error:
    print(error)
"""
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert missing in said
    assert 'pip install "threewe[viz]"' in said
