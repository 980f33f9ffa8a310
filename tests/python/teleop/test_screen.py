"""What the person sees while driving."""

from __future__ import annotations

import io
import logging
import math

import numpy as np
import pytest
from rich.console import Console
from threewe import Intervention, Kinematics, OccupancyGrid, Robot, RobotProfile, Velocity
from threewe.teleop import Driver, Status
from threewe.teleop.local_map import cells_near
from threewe.teleop.obstacles import distances_to_outline, nearest_obstacle
from threewe.teleop.screen import GATE, TeleopScreen
from threewe.teleop.session import key_lines


def status(intervention: Intervention = Intervention.none, driver: Driver = Driver.person, **changes: object) -> Status:
    known: dict[str, object] = {
        "now": 3.0,
        "driver": driver,
        "requested": Velocity(0.5, 0.0, 0.0),
        "executed": Velocity(0.12, 0.0, 0.0),
        "intervention": intervention,
        "level": 9,
        "linear_speed": 0.5,
        "angular_speed": 1.0,
        "emergency_stopped": False,
        "connected": True,
        "recording": False,
        "episodes": 0,
        "message": "",
    }
    return Status(**{**known, **changes})  # type: ignore[arg-type]


def shown(robot: Robot, seen: Status, width: int = 120, **options: bool) -> str:
    text = io.StringIO()
    console = Console(file=text, width=width, height=40, color_system=None, force_terminal=True)
    screen = TeleopScreen(robot, console, "robot on mock", ["W ahead"], **options)
    screen(seen)
    text.seek(0)
    text.truncate()
    console.print(screen)
    return text.getvalue()


async def test_what_was_asked_what_was_done_and_why_not(robot: Robot) -> None:
    text = shown(robot, status(Intervention.slowed_for_obstacle))
    for part in ("ahead +0.50", "ahead +0.12", "slowed for an obstacle", "9 of 9: up to 0.50 m/s", "you", "W ahead"):
        assert part in text
    assert "% " not in text.split("battery")[0]
    assert "100 %" in text


@pytest.mark.parametrize("width", [60, 80, 120, 200])
async def test_it_fits_into_terminals_of_any_width(robot: Robot, width: int) -> None:
    lines = shown(robot, status(message="you drive: t hands back"), width).splitlines()
    assert max(map(len, lines)) <= width
    assert any("█" in line for line in lines) == (width >= 96)


async def test_who_drives_and_what_is_recorded(robot: Robot) -> None:
    text = shown(robot, status(driver=Driver.policy, recording=True, episodes=3), episodes=True, hands_over=True)
    assert "the policy; any drive key takes over" in text
    assert "RECORDING, 3 kept" in text
    assert "an input device is gone" in shown(robot, status(connected=False))


async def test_warnings_of_the_log_become_a_line(robot: Robot, caplog: pytest.LogCaptureFixture) -> None:
    text = io.StringIO()
    console = Console(file=text, width=120, color_system=None, force_terminal=True)
    with TeleopScreen(robot, console, "", []) as screen:
        logging.getLogger("threewe").warning("the wheel came off")
        screen(status())
    assert "the wheel came off" in text.getvalue()
    assert not caplog.records
    logging.getLogger("threewe").warning("after it")
    assert [record.getMessage() for record in caplog.records] == ["after it"]


def test_every_intervention_of_the_gate_has_its_text() -> None:
    assert set(GATE) == set(Intervention)


def test_keys_are_those_that_the_robot_has() -> None:
    for name in ("3we_standard_v2", "turtlebot_like"):
        profile = RobotProfile.load(name)
        lines = " ".join(key_lines(profile, gamepad=True, episodes=True, hands_over=True))
        assert ("A D left, right" in lines) == (profile.kinematics is Kinematics.holonomic)
        assert "Backspace discard" in lines
        assert "hands back" in lines
    assert "stick" not in " ".join(key_lines(profile, gamepad=False))


@pytest.mark.parametrize("seed", range(20))
def test_distances_to_the_outline_are_those_to_its_nearest_point(seed: int) -> None:
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0.0, 2.0 * math.pi, 6))
    outline = np.column_stack([0.4 * np.cos(angles), 0.2 * np.sin(angles)])  # convex: on an ellipse
    along = np.linspace(0.0, 1.0, 400)[:, None]
    edge = np.concatenate([a + along * (b - a) for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True)])
    points = rng.uniform(-1.0, 1.0, (50, 2))
    points = points[np.hypot(*points.T) > 0.45]  # outside
    slow = np.hypot(*(points[:, None] - edge).transpose(2, 0, 1)).min(axis=1)
    np.testing.assert_allclose(distances_to_outline(points, outline), slow, atol=2e-3, err_msg=f"seed {seed}")
    inside = outline.mean(axis=0)[None]
    assert distances_to_outline(inside, outline) == [0.0]


async def test_the_nearest_obstacle_is_the_wall_of_the_corridor(robot: Robot) -> None:
    found = nearest_obstacle(robot)
    assert found is not None
    distance, bearing = found
    scan = robot.get_lidar_scan()
    nearest = int(np.argmin(np.where(scan.ranges > 0.0, scan.ranges, np.inf)))
    assert 0.0 < distance < scan.ranges[nearest]
    assert math.cos(bearing - scan.angle_min - nearest * scan.angle_increment) > 0.7


async def test_a_robot_without_lidar_shows_what_its_ultrasonics_measure() -> None:
    async with Robot(scene="corridor_v1", hardware="3we_base_v2", noise="ideal") as robot:
        text = shown(robot, status())
        assert "nearest" in text
        assert "█" not in text
        found = nearest_obstacle(robot)
        ranges = [r for r in robot.get_ultrasonic_ranges().values() if 0.0 < r.range < r.range_max]
        assert (found is None) == (not ranges)
        if found is not None:
            assert found[0] <= min(reading.range for reading in ranges)


@pytest.mark.parametrize("seed", range(50))
def test_the_cells_near_a_place_are_all_of_them_and_hardly_more(seed: int) -> None:
    rng = np.random.default_rng(seed)
    data = rng.choice([-1, 0, 50, 100], rng.integers(1, 60, 2)).astype(np.int8)
    grid = OccupancyGrid(data, 0.05, tuple(rng.uniform(-2.0, 2.0, 2)))
    (x, y), reach = rng.uniform(-4.0, 4.0, 2), float(rng.uniform(0.0, 3.0))
    rows, columns = np.nonzero(data >= 0)
    every = np.array(grid.origin) + (np.column_stack([columns, rows]) + 0.5) * grid.resolution
    offsets = np.abs(every - (x, y)).max(axis=1)
    cells, values = cells_near(grid, x, y, reach)
    found = {(round(float(a), 6), round(float(b), 6)): int(v) for (a, b), v in zip(cells, values, strict=True)}
    for (a, b), offset, value in zip(every, offsets, data[rows, columns], strict=True):
        key = round(float(a), 6), round(float(b), 6)
        if offset <= reach:
            assert found[key] == value, f"seed {seed}"
        elif offset > reach + 0.15:
            assert key not in found, f"seed {seed}"
