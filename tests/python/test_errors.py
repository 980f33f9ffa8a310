"""Every wrong input gets one clear error that says what would be right, or a result that says why; the robot stands."""

from __future__ import annotations

import asyncio
import builtins
import functools
import inspect
import math
from collections.abc import Awaitable, Callable, Iterator
from contextlib import AbstractAsyncContextManager
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import threewe
from threewe import (
    ConfigError,
    ConnectionError,
    ContractError,
    EmergencyStopError,
    HardwareError,
    NavigationError,
    Pose2D,
    Reason,
    Robot,
    SafetyError,
    ThreeweError,
    TimeoutError,
    Zone,
)

NAN, INF = math.nan, math.inf


def test_errors_are_also_the_built_in_ones() -> None:
    assert issubclass(ConnectionError, builtins.ConnectionError)
    assert issubclass(TimeoutError, builtins.TimeoutError)
    assert issubclass(ContractError, ValueError)
    assert issubclass(ConfigError, ValueError)
    assert issubclass(EmergencyStopError, SafetyError)
    for error in (
        ConnectionError,
        HardwareError,
        NavigationError,
        SafetyError,
        TimeoutError,
        ContractError,
        ConfigError,
    ):
        assert issubclass(error, ThreeweError)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"scene": "ofice_v2"}, "unknown scene 'ofice_v2'; did you mean 'office_v2'"),
        ({"backend": "mok"}, "unknown backend 'mok'; did you mean 'mock'"),
        ({"hardware": "3we_standart_v2"}, "did you mean '3we_standard_v2'"),
        ({"noise": "real"}, "noise.*'real'"),
        ({"randomization": "hrad"}, "unknown randomization 'hrad'; did you mean 'hard'"),
        ({"noise": "idael"}, "did you mean 'ideal'"),
        ({"sceen": "office_v2"}, "unknown option 'sceen'; did you mean 'scene'"),
        ({"scene": "no_such_file.yaml"}, "no_such_file.yaml"),
        ({"start_pose": (1e3, 0.0)}, "obstacle|outside|inside"),
    ],
)
def test_unknown_names(options: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        Robot(**options)  # type: ignore[arg-type]


def test_a_malformed_scene_is_reported_with_file_and_line(tmp_path: Path) -> None:
    file = tmp_path / "broken.yaml"
    file.write_text("name: broken\nwalls: [\n")
    with pytest.raises(ConfigError, match=r"broken\.yaml:\d+"):
        Robot(scene=str(file))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ("category: chair, shape: wooden", r"hall\.yaml:10: objects\[0\]: 'chair_1' overlaps a wall"),
        ("category: chiar, shape: wooden", r"hall\.yaml:10: .*unknown category 'chiar'; did you mean 'chair'"),
        ("category: chair, shape: wodden", r"hall\.yaml:10: .*unknown shape 'wodden'; did you mean 'wooden'"),
    ],
)
def test_a_scene_that_cannot_be_is_reported_with_file_and_line(tmp_path: Path, wrong: str, message: str) -> None:
    file = tmp_path / "hall.yaml"
    file.write_text(
        "name: hall\ndescription: a hall\nstarts: [[1, 2]]\nwalls:\n"
        "  - {a: [0, 0], b: [6, 0]}\n  - {a: [6, 0], b: [6, 4]}\n  - {a: [6, 4], b: [0, 4]}\n"
        "  - {a: [0, 4], b: [0, 0]}\n"
        f"objects:\n  - {{{wrong}, pose: [5, 3.75]}}\n"
    )
    with pytest.raises(ConfigError, match=message):
        Robot(scene=str(file))


def test_a_robot_started_on_another() -> None:
    with pytest.raises(ConfigError, match=r"start pose 1: \(0\.1, 0, 0\) overlaps robot 0"):
        threewe.World(scene="corridor_v1", start_poses=[(0.0, 0.0), (0.1, 0.0)])
    with pytest.raises(ConfigError, match="1 start poses for 2 robots"):
        threewe.World(scene="corridor_v1", start_poses=[(0.0, 0.0)])
    with pytest.raises(ConfigError, match="robots: a world needs at least one"):
        threewe.World(robots=[])


async def test_a_robot_started_where_a_person_walks_is_not_walked_into() -> None:
    scene = threewe.Scene.load("dynamic_v1")
    x, y = scene.people[0].route[0]
    async with Robot(scene="dynamic_v1", noise="ideal", start_pose=(x, y)) as robot:
        assert robot.simulation is not None
        await robot.sleep(5.0)
        assert robot.simulation.max_collision_speed() == 0.0


def test_a_start_inside_a_wall() -> None:
    wall = threewe.Scene.load("corridor_v1").walls[0]
    middle = ((wall.a[0] + wall.b[0]) / 2, (wall.a[1] + wall.b[1]) / 2)
    with pytest.raises(ConfigError):
        Robot(scene="corridor_v1", start_pose=(*middle, 0.0))


@pytest.mark.parametrize("pose", [(1.0,), (1.0, 2.0, 3.0, 4.0), (NAN, 0.0), (0.0, 0.0, INF), "here"])
def test_impossible_poses(pose: object) -> None:
    with pytest.raises(ContractError, match="initial_pose"):
        Robot(initial_pose=pose)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "options", [{"seed": -1}, {"seed": 1.5}, {"seed": 2**64}, {"scene": None}, {"realtime": "yes"}, {"noise": 0}]
)
@pytest.mark.parametrize("make", [Robot, threewe.World])
def test_options_of_a_wrong_type(options: dict[str, object], make: Callable[..., object]) -> None:
    with pytest.raises(ContractError, match=f"^{next(iter(options))} must be"):
        make(**options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"robots": "3we_standard_v2"},
            "robots must be a list with one profile for each robot, such as \\['3we_standard_v2'\\]",
        ),
        ({"robots": None}, "robots must be a list, got None"),
        ({"robots": [None]}, "robots must be a string, got None"),
        ({"start_poses": 3}, "start_poses must be a list, got 3"),
        ({"initial_poses": [(0.0, "x")]}, "initial_poses must hold numbers"),
    ],
)
def test_lists_of_a_wrong_type(options: dict[str, object], message: str) -> None:
    with pytest.raises(ContractError, match=message):
        threewe.World(**options)  # type: ignore[arg-type]


async def test_resetting_and_restoring_wrongly(robot: Robot) -> None:
    truth = robot.simulation
    assert truth is not None
    with pytest.raises(ContractError, match="seed must be"):
        truth.reset(seed=-1)
    with pytest.raises(ConfigError, match="did you mean 'seed'"):
        truth.reset(sed=1)  # type: ignore[call-arg]
    with pytest.raises(ContractError, match="seed must be"):
        truth.sample_free_pose("x")  # type: ignore[arg-type]
    with pytest.raises(ContractError, match=r"b must have shape \(2,\), got \(3,\)"):
        truth.geodesic((0.0, 0.0), (1.0, 2.0, 3.0))
    with pytest.raises(ContractError, match="snapshot must be"):
        truth.restore(None)  # type: ignore[arg-type]
    truth.reset(pose=(0.5, 0.0))
    assert truth.true_pose().x == 0.5


Call = Callable[[Robot], Awaitable[object] | None]

WRONG_CALLS: dict[str, tuple[Call, type[Exception], str]] = {
    "velocity NaN": (lambda r: r.set_velocity(NAN), ContractError, "finite"),
    "velocity infinite": (lambda r: r.set_velocity(0.1, 0.0, -INF), ContractError, "finite"),
    "hold NaN": (lambda r: r.set_velocity(0.1, hold=NAN), ContractError, "hold"),
    "hold negative": (lambda r: r.set_velocity(0.1, hold=-1.0), ContractError, "hold"),
    "goal NaN": (lambda r: r.move_to(NAN, 0.0), ContractError, "finite"),
    "goal infinite": (lambda r: r.move_to(0.0, INF), ContractError, "finite"),
    "goal infinite in y": (lambda r: r.move_to(0.0, INF), ContractError, "goal y must be finite, not inf"),
    "goal of words": (lambda r: r.move_to("a", 0.0), ContractError, "goal x must be a number"),  # type: ignore[arg-type]
    "frame None": (lambda r: r.move_to(0.0, 0.0, frame=None), ContractError, "frame must be a string"),  # type: ignore[arg-type]
    "velocity of words": (lambda r: r.set_velocity("a"), ContractError, "vx must be a number"),  # type: ignore[arg-type]
    "heading NaN": (lambda r: r.move_to(1.0, 0.0, NAN), ContractError, "finite"),
    "tolerance NaN": (lambda r: r.move_to(1.0, 0.0, tolerance=NAN), ContractError, "tolerance"),
    "tolerance negative": (lambda r: r.move_to(1.0, 0.0, tolerance=-0.1), ContractError, "tolerance"),
    "angle tolerance NaN": (lambda r: r.move_to(1.0, 0.0, angle_tolerance=NAN), ContractError, "angle_tolerance"),
    "angle tolerance zero": (lambda r: r.rotate(1.0, angle_tolerance=0.0), ContractError, "angle tolerance"),
    "tolerance without end": (lambda r: r.move_to(1.0, 0.0, tolerance=1e6), ContractError, "at most 10 m"),
    "tolerance of a distance": (lambda r: r.move_forward(1.0, tolerance=-1.0), ContractError, "tolerance"),
    "zones no list": (lambda r: r.set_zones(3), ContractError, "zones must be a list"),  # type: ignore[arg-type]
    "zone no Zone": (lambda r: r.set_zones([(0, 0)]), ContractError, "zones must hold Zones"),  # type: ignore[list-item]
    "zone of two corners": (
        lambda r: r.set_zones([Zone([(0, 0), (1, 0)])]),
        ContractError,
        "at least 3 corners, not 2",
    ),
    "zone without speed": (
        lambda r: r.set_zones([Zone([(0, 0), (1, 0), (1, 1)], speed_limit=0.0)]),
        ContractError,
        "speed_limit must be positive",
    ),
    "timeout NaN": (lambda r: r.move_to(1.0, 0.0, timeout=NAN), ContractError, "timeout"),
    "timeout negative": (lambda r: r.move_to(1.0, 0.0, timeout=-1.0), ContractError, "timeout"),
    "timeout zero": (lambda r: r.move_to(1.0, 0.0, timeout=0.0), ContractError, "timeout"),
    "frame of transform": (lambda r: r.get_transform(3, "map"), ContractError, "target must be a string"),  # type: ignore[return-value, arg-type]
    "observer": (lambda r: r.observe(3), ContractError, "observer must be a function, got 3"),  # type: ignore[return-value, arg-type]
    "on_progress": (lambda r: r.rotate(1.0, on_progress=3), ContractError, "on_progress must be a function"),  # type: ignore[arg-type]
    "frame unknown": (lambda r: r.move_to(1.0, 0.0, frame="mep"), ContractError, "did you mean 'map'"),
    "option unknown": (
        lambda r: r.move_to(1.0, 0.0, tolerence=0.1),  # type: ignore[call-arg]
        ConfigError,
        "did you mean 'tolerance'",
    ),
    "distance NaN": (lambda r: r.move_forward(NAN), ContractError, "finite"),
    "angle infinite": (lambda r: r.rotate(INF), ContractError, "finite"),
    "waypoints empty": (lambda r: r.follow_waypoints([]), ContractError, "waypoints must have at least one place"),
    "waypoints of four": (lambda r: r.follow_waypoints([(1.0, 2.0, 3.0, 4.0)]), ContractError, r"waypoints\[0\]"),
    "waypoints NaN": (lambda r: r.follow_waypoints([(0.0, 0.0), (1.0, NAN)]), ContractError, "finite"),
    "waypoints in one word": (lambda r: r.follow_waypoints("kitchen"), ContractError, "must be a list"),  # type: ignore[arg-type]
    "waypoints of words": (lambda r: r.follow_waypoints(["a"]), ContractError, r"waypoints\[0\]"),  # type: ignore[list-item]
    "path empty": (lambda r: r.follow_path([]), ContractError, "path"),
    "path of triples": (lambda r: r.follow_path([(1.0, 2.0, 3.0)]), ContractError, r"shape \(N, 2\)"),
    "path NaN": (lambda r: r.follow_path([(1.0, NAN)]), ContractError, "finite"),
    "path of numbers in words": (lambda r: r.follow_path([["1", "2"]]), ContractError, "path must hold numbers"),  # type: ignore[list-item]
    "path of words": (lambda r: r.follow_path(["kitchen"]), ContractError, "numbers"),  # type: ignore[list-item]
    "action of two": (lambda r: r.execute_action([0.1, 0.2]), ContractError, r"shape \(3,\), got \(2,\)"),
    "action NaN": (lambda r: r.execute_action(np.array([0.0, NAN, 0.0])), ContractError, "finite"),
    "period NaN": (lambda r: r.execute_action([0.1, 0.0, 0.0], NAN), ContractError, "period"),
    "sleep NaN": (lambda r: r.sleep(NAN), ContractError, "seconds"),
    "sleep negative": (lambda r: r.sleep(-1.0), ContractError, "seconds"),
    "transform unknown": (lambda r: r.get_transform("map", "lidra"), ContractError, "did you mean 'lidar'"),  # type: ignore[return-value, arg-type]
    "depth camera": (lambda r: r.get_rgbd_image(), HardwareError, "measures no depth"),
    "fisheye": (lambda r: r.get_image("fisheye"), HardwareError, "fisheye"),
    "camera unknown": (lambda r: r.get_image("camra"), ContractError, "did you mean 'camera'"),
}


NUMBERS: dict[str, Callable[[Robot, Any], Awaitable[object] | None]] = {
    "vx": lambda r, x: r.set_velocity(x),
    "hold": lambda r, x: r.set_velocity(0.1, hold=x),
    "goal x": lambda r, x: r.move_to(x, 0.0),
    "tolerance": lambda r, x: r.move_to(1.0, 0.0, tolerance=x),
    "timeout": lambda r, x: r.move_to(1.0, 0.0, timeout=x),
    "distance": lambda r, x: r.move_forward(x),
    "angle": lambda r, x: r.rotate(x),
    "period": lambda r, x: r.execute_action([0.1, 0.0, 0.0], x),
    "seconds": lambda r, x: r.sleep(x),
}
OTHER_NUMBERS: list[tuple[str, Callable[[Robot, Any], Awaitable[object]]]] = [
    ("timeout", lambda r, x: r.move_forward(1.0, timeout=x)),
    ("timeout", lambda r, x: r.rotate(1.0, timeout=x)),
    ("timeout", lambda r, x: r.follow_path([(1.0, 0.0)], timeout=x)),
    ("tolerance", lambda r, x: r.follow_path([(1.0, 0.0)], tolerance=x)),
    ("timeout", lambda r, x: r.follow_waypoints([(1.0, 0.0)], timeout=x)),
    ("tolerance", lambda r, x: r.follow_waypoints([(1.0, 0.0)], tolerance=x)),
    ("angle_tolerance", lambda r, x: r.follow_waypoints([(1.0, 0.0)], angle_tolerance=x)),
    ("timeout", lambda r, x: r.explore(timeout=x)),
    ("seconds", lambda r, x: enter(r.timeout(x))),
    ("seconds", lambda r, x: enter(r.thinking(seconds=x))),
]


async def enter(block: AbstractAsyncContextManager[object]) -> None:
    async with block:
        pass


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("fast", "must be a number, got 'fast'"),
        ("1.0", "must be a number, got '1.0'"),
        ([1.0], r"must be a number, got \[1.0\]"),
        (np.array([1.0]), r"must be a number, got array\(\[1.\]\)"),
        (True, "must be a number, got True"),
        (1j, "must be a number, got 1j"),
        (NAN, "must be finite, not nan"),
        (-INF, "must be finite, not -inf"),
        (10**400, "must be finite, not inf"),
    ],
)
async def test_what_is_no_number_is_refused_by_the_name_of_its_argument(
    value: object, message: str, robot: Robot
) -> None:
    for name, call in [*NUMBERS.items(), *OTHER_NUMBERS]:
        with pytest.raises(ContractError, match=f"^{name} {message}"):
            await perform(lambda r, call=call: call(r, value), robot)  # type: ignore[misc]
    for name in ("distance", "angle", "tolerance", "hold", "period", "seconds"):
        with pytest.raises(ContractError, match=f"^{name} must be a number, got None"):
            await perform(lambda r, name=name: NUMBERS[name](r, None), robot)  # type: ignore[misc]
    await stands_still(robot)


@pytest.mark.parametrize("number", [0.2, np.float32(0.2), np.array(0.2), Fraction(1, 5)])
async def test_numbers_of_all_kinds(number: float, robot: Robot) -> None:
    robot.set_velocity(number, hold=number)
    await robot.sleep(number)
    assert (await robot.move_forward(number, timeout=np.float64(20.0))).success
    assert (await robot.rotate(number)).success


@pytest.mark.parametrize("seconds", [-0.1, 1e10, 1e300])
async def test_impossible_lengths_of_time(seconds: float, robot: Robot) -> None:
    for name in ("hold", "timeout", "period", "seconds"):
        with pytest.raises(ContractError, match=rf"^{name} must lie in \[0, 1e\+09\] s, got "):
            await perform(lambda r, name=name: NUMBERS[name](r, seconds), robot)  # type: ignore[misc]


async def perform(call: Call, robot: Robot) -> None:
    result = call(robot)
    if isinstance(result, Awaitable):
        await result


@pytest.mark.parametrize("name", WRONG_CALLS)
async def test_wrong_calls(name: str, robot: Robot) -> None:
    call, error, message = WRONG_CALLS[name]
    with pytest.raises(error, match=message):
        await perform(call, robot)
    await stands_still(robot)


async def stands_still(robot: Robot) -> None:
    assert robot.simulation is not None
    before = robot.simulation.true_pose()
    await robot.sleep(0.2)
    assert robot.simulation.true_pose().distance(before) < 1e-3


async def test_sideways_on_a_differential_base(differential_robot: Robot) -> None:
    with pytest.raises(ContractError, match=r"vy|sideways"):
        differential_robot.set_velocity(0.1, 0.1, 0.0)
    with pytest.raises(ContractError, match=r"vy|sideways"):
        await differential_robot.execute_action([0.0, 0.5, 0.0])
    await stands_still(differential_robot)


CALLS: dict[str, Call] = {
    "move_to": lambda r: r.move_to(1.0, 0.0),
    "move_forward": lambda r: r.move_forward(1.0),
    "rotate": lambda r: r.rotate(1.0),
    "follow_path": lambda r: r.follow_path([(1.0, 0.0)]),
    "follow_waypoints": lambda r: r.follow_waypoints([(1.0, 0.0)]),
    "explore": lambda r: r.explore(),
    "execute_action": lambda r: r.execute_action([0.0, 0.0, 0.0]),
    "sleep": lambda r: r.sleep(0.1),
    "set_velocity": lambda r: r.set_velocity(0.1),
    "get_lidar_scan": lambda r: r.get_lidar_scan(),  # type: ignore[dict-item, return-value]
    "get_imu": lambda r: r.get_imu(),  # type: ignore[dict-item, return-value]
    "get_pose": lambda r: r.get_pose(),  # type: ignore[dict-item, return-value]
    "get_odometry": lambda r: r.get_odometry(),  # type: ignore[dict-item, return-value]
    "get_velocity": lambda r: r.get_velocity(),  # type: ignore[dict-item, return-value]
    "get_map": lambda r: r.get_map(),  # type: ignore[dict-item, return-value]
    "get_people": lambda r: r.get_people(),  # type: ignore[dict-item, return-value]
    "get_battery_state": lambda r: r.get_battery_state(),  # type: ignore[dict-item, return-value]
    "get_ultrasonic_ranges": lambda r: r.get_ultrasonic_ranges(),  # type: ignore[dict-item, return-value]
    "get_transform": lambda r: r.get_transform("map", "base"),  # type: ignore[dict-item, return-value]
    "get_observation": lambda r: r.get_observation(),  # type: ignore[dict-item, return-value]
}


@pytest.mark.parametrize("name", CALLS)
def test_calls_before_connect(name: str, robot: Robot) -> None:
    assert not robot.connected
    with pytest.raises(ConnectionError, match="connect"):
        asyncio.run(perform(CALLS[name], robot))


@pytest.mark.parametrize("name", CALLS)
async def test_calls_after_disconnect(name: str, robot: Robot) -> None:
    await robot.disconnect()
    with pytest.raises(ConnectionError, match="connect"):
        await perform(CALLS[name], robot)


async def test_a_map_that_was_read_before_is_not_told_after_disconnect(robot: Robot) -> None:
    robot.get_map()
    await robot.disconnect()
    with pytest.raises(ConnectionError, match="connect"):
        robot.get_map()


def in_a_wall(robot: Robot) -> tuple[float, float]:
    """The middle of the nearest."""
    assert robot.simulation is not None
    walls = robot.simulation.scene.walls
    wall = min(walls, key=lambda wall: math.hypot(wall.a[0] + wall.b[0], wall.a[1] + wall.b[1]))
    return (wall.a[0] + wall.b[0]) / 2, (wall.a[1] + wall.b[1]) / 2


async def test_a_goal_in_a_wall_is_no_path(robot: Robot) -> None:
    result = await robot.move_to(*in_a_wall(robot), tolerance=0.05)
    assert result.reason is Reason.no_path, result
    assert not result
    with pytest.raises(NavigationError):
        result.raise_for_failure()
    await stands_still(robot)


async def test_a_waypoint_in_a_wall_is_named(robot: Robot) -> None:
    result = await robot.follow_waypoints([(0.3, 0.0), in_a_wall(robot), (0.0, 0.0)], tolerance=0.05, timeout=120.0)
    assert result.reason is Reason.no_path, result
    assert result.detail.startswith("waypoint 2 of 3: ")


async def test_a_goal_outside_the_world_is_no_path(robot: Robot) -> None:
    """Once the robot has seen for itself that there is no way."""
    assert robot.simulation is not None
    result = await robot.move_to(robot.simulation.scene.max[0] + 50.0, 0.0, timeout=1000.0)
    assert result.reason is Reason.no_path, result
    with pytest.raises(NavigationError):
        result.raise_for_failure()
    await robot.sleep(0.5)  # until it has braked
    await stands_still(robot)


async def test_two_owners(robot: Robot) -> None:
    moving = asyncio.create_task(robot.move_to(2.0, 0.0))
    await robot.sleep(0.1)
    for call in (CALLS["move_to"], CALLS["rotate"], CALLS["explore"], CALLS["set_velocity"], CALLS["execute_action"]):
        with pytest.raises(SafetyError):
            await perform(call, robot)
    result = await moving
    assert result.success, result


async def test_the_emergency_stop_latches(robot: Robot) -> None:
    moving = asyncio.create_task(robot.move_to(2.0, 0.0))
    await robot.sleep(1.0)
    robot.emergency_stop()
    result = await moving
    assert result.reason is Reason.estop
    with pytest.raises(EmergencyStopError):
        result.raise_for_failure()
    for call in (CALLS["move_to"], CALLS["set_velocity"], CALLS["explore"]):
        with pytest.raises(EmergencyStopError):
            await perform(call, robot)
    await robot.sleep(0.3)
    await stands_still(robot)
    robot.release_emergency_stop()
    assert (await robot.move_forward(0.2)).success


async def test_the_emergency_stop_works_from_any_thread(robot: Robot) -> None:
    moving = asyncio.create_task(robot.explore())
    await robot.sleep(1.0)
    async with robot.thinking(seconds=0.0):
        await asyncio.to_thread(robot.emergency_stop)
    assert (await moving).reason is Reason.estop


CALLED_WITH: dict[str, dict[str, object]] = {
    "add_skill": {"function": print},
    "get_transform": {"target": "map", "source": "base"},
    "save_map": {"path": "map.yaml"},
    "name_place": {"name": "dock"},
    "load_places": {"path": "places.yaml"},
    "save_places": {"path": "places.yaml"},
    "set_zones": {"zones": []},
    "observe": {"observer": print},
    "unobserve": {"number": 1},
    "sample_free_pose": {"seed": 1},
    "geodesic": {"a": (0.0, 0.0), "b": (1.0, 0.0)},
    "teleport": {"pose": (0.0, 0.0)},
}


def reads_and_commands(owner: object) -> Iterator[tuple[str, Callable[[], object]]]:
    """Every public property and method of something that a thread uses, but for coroutines and what never changes."""
    lasting = {"profile", "features", "simulation", "timeout", "thinking", "restore", "emergency_stop", "disconnect"}
    for name, member in inspect.getmembers(type(owner)):
        if name.startswith("_") or name in lasting:
            continue
        if callable(member):
            if inspect.iscoroutinefunction(inspect.unwrap(member)):
                continue
            yield name, functools.partial(getattr(owner, name), **CALLED_WITH.get(name, {}))
        else:
            yield name, functools.partial(getattr, owner, name)


def outcome(call: Callable[[], object]) -> str:
    """What a call raises, or returns."""
    try:
        return f"returned {call()!r}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"


async def test_everything_else_is_refused_on_other_threads(robot: Robot) -> None:
    assert robot.simulation is not None
    calls = [*reads_and_commands(robot), *reads_and_commands(robot.simulation)]
    names = {name for name, _ in calls}
    assert {"health", "lost", "now", "get_image", "true_pose", "look", "reset", "save", "scene"} <= names
    answered = {name: await asyncio.to_thread(outcome, call) for name, call in calls}
    assert {name: answer for name, answer in answered.items() if "threewe.sync.Robot" not in answer} == {}
    assert "another thread" in await asyncio.to_thread(repr, robot)


async def test_a_world_is_whosever_connects_it() -> None:
    robot = Robot(noise="ideal")
    await asyncio.to_thread(lambda: robot.now)

    async def there() -> float:
        async with robot:
            await robot.sleep(0.1)
            return robot.get_pose().x

    assert await asyncio.to_thread(lambda: asyncio.run(there())) == 0.0
    async with robot:
        assert robot.lost is False


async def test_resetting_into_a_wall(robot: Robot) -> None:
    assert robot.simulation is not None
    wall = robot.simulation.scene.walls[0]
    with pytest.raises(ConfigError):
        robot.simulation.reset(pose=Pose2D(*wall.a, 0.0))


async def test_saving_during_a_motion(robot: Robot) -> None:
    assert robot.simulation is not None
    moving = asyncio.create_task(robot.move_to(2.0, 0.0))
    await robot.sleep(0.1)
    with pytest.raises(ContractError):
        robot.simulation.save()
    robot.stop()
    assert (await moving).reason is Reason.cancelled
