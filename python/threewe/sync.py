"""The same robot without `async`, for scripts: every method blocks until it is done.

from threewe.sync import Robot

with Robot() as robot:
    result = robot.move_to(2.0, 1.0)
"""

from __future__ import annotations

import functools
import time
import weakref
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Concatenate, ParamSpec, Self, TypeVar

import threewe
from threewe._arguments import as_function, as_seconds
from threewe._core import Features, LocalizationState, Pose2D, RobotProfile, SensorHealth
from threewe._loop_thread import LoopThread

P = ParamSpec("P")
R = TypeVar("R")
Owner = TypeVar("Owner", bound="_Connected")
Target = TypeVar("Target")


def _options(
    make: Callable[P, Target],
) -> Callable[[Callable[[Owner, Target], None]], Callable[Concatenate[Owner, P], None]]:
    """Lets a constructor that takes a robot or a world take the options of it."""

    def decorate(init: Callable[[Owner, Target], None]) -> Callable[Concatenate[Owner, P], None]:
        @functools.wraps(make.__init__)
        def construct(self: Owner, /, *args: P.args, **options: P.kwargs) -> None:
            init(self, make(*args, **options))

        return construct

    return decorate


class _OnThread:
    """Something whose methods run on a loop's thread."""

    _thread: LoopThread
    _target: Any


def _waits(method: Callable[Concatenate[Any, P], Coroutine[Any, Any, R]]) -> Callable[Concatenate[_OnThread, P], R]:
    """The blocking form of a coroutine."""

    @functools.wraps(method)
    def call(self: _OnThread, /, *args: P.args, **options: P.kwargs) -> R:
        return self._thread.wait(lambda: method(self._target, *args, **options))

    return call


def _returns(method: Callable[Concatenate[Any, P], R]) -> Callable[Concatenate[_OnThread, P], R]:
    """The same method, on the loop's thread."""

    @functools.wraps(method)
    def call(self: _OnThread, /, *args: P.args, **options: P.kwargs) -> R:
        return self._thread.call(lambda: method(self._target, *args, **options))

    return call


class Simulation(_OnThread):
    """`threewe.Simulation` for scripts."""

    def __init__(self, robot: Robot, truth: threewe.Simulation) -> None:
        self._robot = robot  # which ends its thread when it is garbage-collected
        self._thread = robot._thread
        self._target = truth
        self.scene = truth.scene
        self.profile = truth.profile

    @property
    def scene_from_map(self) -> Pose2D:
        """Where the origin of the robot's map truly is."""
        truth: threewe.Simulation = self._target
        return self._thread.call(lambda: truth.scene_from_map)

    true_pose = _returns(threewe.Simulation.true_pose)
    true_velocity = _returns(threewe.Simulation.true_velocity)
    start_pose = _returns(threewe.Simulation.start_pose)
    max_collision_speed = _returns(threewe.Simulation.max_collision_speed)
    distance_driven = _returns(threewe.Simulation.distance_driven)
    people = _returns(threewe.Simulation.people)
    look = _returns(threewe.Simulation.look)
    sample_free_pose = _returns(threewe.Simulation.sample_free_pose)
    geodesic = _returns(threewe.Simulation.geodesic)
    teleport = _returns(threewe.Simulation.teleport)
    reset = _returns(threewe.Simulation.reset)
    save = _returns(threewe.Simulation.save)
    restore = _returns(threewe.Simulation.restore)


class _Connected(_OnThread):
    """What a robot and a world of robots share: a thread, a connection and robot time."""

    _target: threewe.Robot | threewe.World

    def _begin(self, target: threewe.Robot | threewe.World) -> None:
        self._target = target
        self._thread = LoopThread(target.disconnect)
        weakref.finalize(self, self._thread.close)

    def __repr__(self) -> str:
        return self._thread.call(lambda: f"sync.{self._target!r}")

    def connect(self) -> Self:
        """Connects and waits until every sensor has delivered. Raises ConnectionError."""
        self._thread.wait(self._target.connect)
        return self

    def disconnect(self) -> None:
        """Ends motions as `cancelled`, stops and lets go."""
        self._thread.wait(self._target.disconnect)

    def __enter__(self) -> Self:
        return self.connect()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.disconnect()

    @property
    def now(self) -> float:
        """Robot time [s]."""
        return self._thread.call(lambda: self._target.now)

    def sleep(self, seconds: float) -> None:
        """Lets `seconds` of robot time go by."""
        self._thread.wait(lambda: self._target.sleep(seconds))

    @contextmanager
    def thinking(self, seconds: float | None = None) -> Iterator[None]:
        """`with robot.thinking(seconds=x):` lets `x` seconds of robot time go by at the end of the block.

        Without `x` as many as the wall clock counted.
        """
        charge = None if seconds is None else as_seconds("seconds", seconds)
        began = time.perf_counter()
        yield
        if self._lockstep():
            self.sleep(time.perf_counter() - began if charge is None else charge)

    def _lockstep(self) -> bool:
        raise NotImplementedError


class Robot(_Connected):
    """`threewe.Robot` for scripts: the same options and methods, each of which blocks until it is done.

    The robot lives on an event loop in a thread of its own; robot time stands still between two calls. It is
    disconnected at the end of a `with` block, and at the latest when it is garbage-collected or Python ends.
    """

    _target: threewe.Robot
    _world: World | None = None  # which ends its thread when it is garbage-collected

    @_options(threewe.Robot)
    def __init__(self, robot: threewe.Robot) -> None:
        self._begin(robot)

    @classmethod
    def _of_world(cls, world: World, robot: threewe.Robot) -> Self:
        """A robot of a world that others share."""
        shared = cls.__new__(cls)
        shared._world, shared._thread, shared._target = world, world._thread, robot
        return shared

    @property
    def connected(self) -> bool:
        """True between `connect` and `disconnect`."""
        return self._thread.call(lambda: self._target.connected)

    @property
    def profile(self) -> RobotProfile:
        """What the robot is: its body, limits and sensors."""
        return self._target.profile

    @property
    def features(self) -> Features:
        """What the robot can do on this backend."""
        return self._target.features

    @property
    def health(self) -> dict[str, SensorHealth]:
        """How each sensor is, by its name."""
        return self._thread.call(lambda: self._target.health)

    @property
    def lost(self) -> bool:
        """True while the robot does not know where it is."""
        return self._thread.call(lambda: self._target.lost)

    @property
    def localization(self) -> str:
        """Who says where the robot is and draws its map: `slam`, `truth`, `amcl` or `slam_toolbox`."""
        return self._thread.call(lambda: self._target.localization)

    @property
    def navigation(self) -> str:
        """Who drives to positions and along paths: `own` or `nav2`."""
        return self._thread.call(lambda: self._target.navigation)

    @property
    def localization_state(self) -> LocalizationState:
        """How far the robot knows where it is."""
        return self._thread.call(lambda: self._target.localization_state)

    @property
    def emergency_stopped(self) -> bool:
        """True while the emergency stop is latched."""
        return self._thread.call(lambda: self._target.emergency_stopped)

    @property
    def simulation(self) -> Simulation | None:
        """The truth, in a simulated world; None on a real robot."""
        truth = self._target.simulation
        return None if truth is None else self._thread.call(lambda: Simulation(self, truth))

    def _lockstep(self) -> bool:
        return self.features.lockstep

    move_to = _waits(threewe.Robot.move_to)
    move_forward = _waits(threewe.Robot.move_forward)
    rotate = _waits(threewe.Robot.rotate)
    follow_path = _waits(threewe.Robot.follow_path)
    follow_waypoints = _waits(threewe.Robot.follow_waypoints)
    explore = _waits(threewe.Robot.explore)
    execute_action = _waits(threewe.Robot.execute_action)
    execute_instruction = _waits(threewe.Robot.execute_instruction)
    execute_skill = _waits(threewe.Robot.execute_skill)

    set_velocity = _returns(threewe.Robot.set_velocity)
    set_zones = _returns(threewe.Robot.set_zones)
    add_skill = _returns(threewe.Robot.add_skill)
    get_skills = _returns(threewe.Robot.get_skills)
    name_place = _returns(threewe.Robot.name_place)
    load_places = _returns(threewe.Robot.load_places)
    save_places = _returns(threewe.Robot.save_places)
    get_places = _returns(threewe.Robot.get_places)
    get_things = _returns(threewe.Robot.get_things)
    stop = _returns(threewe.Robot.stop)
    emergency_stop = _returns(threewe.Robot.emergency_stop)
    release_emergency_stop = _returns(threewe.Robot.release_emergency_stop)
    get_lidar_scan = _returns(threewe.Robot.get_lidar_scan)
    get_imu = _returns(threewe.Robot.get_imu)
    get_odometry = _returns(threewe.Robot.get_odometry)
    get_battery_state = _returns(threewe.Robot.get_battery_state)
    get_people = _returns(threewe.Robot.get_people)
    get_ultrasonic_ranges = _returns(threewe.Robot.get_ultrasonic_ranges)
    get_pose = _returns(threewe.Robot.get_pose)
    get_pose_covariance = _returns(threewe.Robot.get_pose_covariance)
    get_velocity = _returns(threewe.Robot.get_velocity)
    get_transform = _returns(threewe.Robot.get_transform)
    get_map = _returns(threewe.Robot.get_map)
    save_map = _returns(threewe.Robot.save_map)
    get_path = _returns(threewe.Robot.get_path)
    get_plan = _returns(threewe.Robot.get_plan)
    get_observation = _returns(threewe.Robot.get_observation)
    get_camera_image = _returns(threewe.Robot.get_camera_image)
    get_image = _returns(threewe.Robot.get_image)
    get_rgbd_image = _returns(threewe.Robot.get_rgbd_image)
    observe = _returns(threewe.Robot.observe)
    unobserve = _returns(threewe.Robot.unobserve)


class World(_Connected):
    """`threewe.World` for scripts: several robots in one world, on one thread; `together` lets them act at once."""

    _target: threewe.World

    @_options(threewe.World)
    def __init__(self, world: threewe.World) -> None:
        self._begin(world)

    @property
    def robots(self) -> tuple[Robot, ...]:
        """The robots, in the order in which they were named."""
        return tuple(Robot._of_world(self, robot) for robot in self._target.robots)

    def together(self, *calls: Callable[[], R]) -> list[R]:
        """What several calls return that begin at the same moment of robot time and go on side by side.

        `world.together(lambda: a.move_to(2, 1), b.explore)`. Each is one call that waits for robot time. Where one
        raises, the others are cancelled.
        """
        return self._thread.wait_together([as_function("calls", call) for call in calls])

    def _lockstep(self) -> bool:
        return all(robot.features.lockstep for robot in self._target.robots)
