"""One robot, the same on every backend."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from threewe import _core
from threewe._arguments import (
    PoseLike,
    as_array,
    as_asset,
    as_function,
    as_image_size,
    as_list,
    as_map,
    as_number,
    as_path,
    as_pose,
    as_seconds,
    as_seed,
    as_switch,
    as_text,
    as_waypoints,
)
from threewe._core import (
    BatteryState,
    Detector,
    ExploreResult,
    Features,
    IMUData,
    LaserScan,
    LocalizationState,
    MappedThing,
    Motion,
    MoveResult,
    OccupancyGrid,
    Odometry,
    Place,
    Pose2D,
    Progress,
    RangeData,
    RGBDImage,
    RobotOptions,
    RobotProfile,
    SampledPlan,
    SensorHealth,
    SensorType,
    TrackedPerson,
    Velocity,
    Zone,
)
from threewe._execution_result import ExecutionResult
from threewe._instructions import Instructions
from threewe._model_options import model_options
from threewe._observers import Observer, Observers
from threewe._options import known_options, known_options_but
from threewe._own_detector import load_detector
from threewe._time import InRobotTime, RobotTime
from threewe._user_skills import SkillFunction, SkillInfo
from threewe.backend import known_backend
from threewe.errors import ContractError, ThreeweError
from threewe.simulation import Simulation

if TYPE_CHECKING:
    from threewe.viewer import Viewer

OnProgress = Callable[[Progress], object]

DETECTOR = "indoor_v1"
SEVERAL = "a Robot is one robot, with its `hardware`; several in one world are a World(robots=[...])"


class Robot(InRobotTime):
    """A robot in a world of its own.

    Use it as `async with Robot(...) as robot:`, or `robot = await Robot(...).connect()` in a notebook. Coroutines let
    robot time go by; everything else returns at once. In lockstep backends (the simulators) robot time stands still
    whenever no task waits for it.

    Args:
        backend: where the robot is: `mock` is the embedded simulator; see `threewe.backend_names()`.
        hardware: the robot profile, see `threewe.profile_names()`, or a file that ends in .yaml.
        scene: the simulated place, see `threewe.scene_names()`, or a file that ends in .yaml.
        map: a map to be localised in, or the file `map.yaml` of one as ROS has maps. The robot draws its own without.
        initial_pose: where the robot starts in its `map` frame: a Pose2D or (x, y, theta) [m, m, rad]. Where left out,
            at the origin of its own map; in a given one it finds out, and is `lost` until then.
        noise: `realistic`, or `ideal` for sensors and wheels without any imperfection.
        seed: of all noise. The same seed and program give the same run, to the bit.
        realtime: pace a simulator to the wall clock.
        start_pose: where a simulated robot starts in its scene; the scene's own start where left out. People who would
            begin there begin farther on.
        localization: `slam`, the robot's own; or `truth`, which simulators know: where what is asked is how well the
            rest does without doubts about the pose; or a program on a real robot, `amcl` or `slam_toolbox`: pose,
            covariance and map are then what it says.
        navigation: `own`; or `nav2` on a real robot that such a program localises: Nav2 drives to positions and along
            paths, and the safety gate is not in its way.
        image_size: (height, width) [px] of what the camera delivers; as the profile states where left out.
        randomization: how the robot differs from its profile in a simulator, drawn anew for each seed and
            episode: `none`, `mild`, `paper`, `hard`, or a file that ends in .yaml.
        detector: what sees things for instructions: one that ships, or a file that ends in .onnx, with its labels and
            layout in a YAML file beside it (extra `policy`), or in .safetensors.
        viewer: streams to Rerun from `connect` to `disconnect`: `rerun` opens a window, `web` serves browsers on
            this machine, `network` all who can reach it, without asking them for a password; a file that ends in .rrd
            is recorded.

    Raises:
        ConfigError: an unknown backend, profile, scene, viewer or option (with the nearest right name), a start in a
            wall, or a map that cannot be read.
        HardwareError: a map for a robot without a lidar.
    """

    _viewer: Viewer | None = None
    _given_map: OccupancyGrid | None = None
    _detector: Detector | None = None  # the one that ships

    @known_options_but({"robots": SEVERAL, "start_poses": SEVERAL, "initial_poses": SEVERAL})
    def __init__(
        self,
        backend: str = "mock",
        hardware: str | os.PathLike[str] = "3we_standard_v2",
        scene: str | os.PathLike[str] = "office_v2",
        map: OccupancyGrid | str | os.PathLike[str] | None = None,
        initial_pose: PoseLike | None = None,
        noise: str = "realistic",
        seed: int = 0,
        realtime: bool = False,
        *,
        start_pose: PoseLike | None = None,
        localization: str = "slam",
        navigation: str = "own",
        image_size: Sequence[int] | None = None,
        randomization: str | os.PathLike[str] = "none",
        detector: str | os.PathLike[str] = DETECTOR,
        viewer: str | None = None,
    ) -> None:
        if isinstance(hardware, list | tuple):
            raise ContractError(f"hardware must be a string, got {hardware!r}: {SEVERAL}")
        initial = None if initial_pose is None else as_pose("initial_pose", initial_pose)
        options = RobotOptions(
            backend=known_backend(as_text("backend", backend)),
            hardware=as_asset("hardware", hardware),
            scene=as_asset("scene", scene),
            noise=as_text("noise", noise),
            seed=as_seed("seed", seed),
            realtime=as_switch("realtime", realtime),
            map=None if map is None else as_map("map", map),
            initial_pose=initial,
            start_pose=None if start_pose is None else as_pose("start_pose", start_pose),
            localization=as_text("localization", localization),
            navigation=as_text("navigation", navigation),
            image_size=None if image_size is None else as_image_size("image_size", image_size),
            randomization=as_asset("randomization", randomization),
        )
        world = _core.World(options)
        self._set_up(world, RobotTime(world), 0)
        self._given_map = options.map
        if (named := as_asset("detector", detector)) != DETECTOR:
            self._detector = load_detector(named)
        if viewer is not None:
            from threewe.viewer import Viewer  # needs packages that only viewers need

            self._viewer = Viewer(self, as_text("viewer", viewer))

    @classmethod
    def _of_world(cls, world: _core.World, robot_time: RobotTime, index: int) -> Self:
        """A robot of a world that others share."""
        robot = cls.__new__(cls)
        robot._set_up(world, robot_time, index)
        return robot

    def _set_up(self, world: _core.World, robot_time: RobotTime, index: int) -> None:
        self._world = world
        self._time = robot_time
        self._index = index
        self._runtime = world.robot(index)
        self._profile, self._features = self._runtime.profile, self._runtime.features
        self._simulation = Simulation(world, index, robot_time) if world.simulated else None
        self._map: tuple[int, OccupancyGrid] | None = None
        self._observers = Observers(self._runtime)
        self._instructions: Instructions | None = None
        self._stops = 0  # calls of `stop`: a policy that drives ends then

    def __repr__(self) -> str:
        if self._time.elsewhere:
            return f"Robot({self.profile.name!r}, in use on another thread)"
        state = "connected" if self.connected else "not connected"
        return f"Robot({self.profile.name!r}, {state}, robot time {self.now:.2f} s)"

    # Connecting

    async def connect(self) -> Self:
        """Connects and waits until every sensor has delivered. Raises ConnectionError. Twice is as good as once."""
        self._time.start()
        try:
            await self._time.wait(self._begin_connecting())
            if self._viewer is not None:
                self._viewer.begin()
        except BaseException:  # also when cancelled: a robot that no caller has got must not stay connected
            with suppress(ThreeweError):
                await self.disconnect()
            raise
        return self

    def _begin_connecting(self) -> _core.Wait:
        """What becomes done when every sensor has delivered."""
        self._runtime.connect()
        return self._runtime.ready()

    async def disconnect(self) -> None:
        """Ends a motion as `cancelled`, stops the robot and lets go of it."""
        self._time.check_thread()
        if self._viewer is not None:
            self._viewer.end()
        try:
            self._runtime.disconnect()
        finally:
            if not any(self._world.robot(i).connected for i in range(self._world.robot_count)):
                self._time.stop()

    async def __aenter__(self) -> Self:
        return await self.connect()

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        await self.disconnect()

    @property
    def connected(self) -> bool:
        """True between `connect` and `disconnect`."""
        return self._runtime.connected

    @property
    def profile(self) -> RobotProfile:
        """What the robot is: its body, limits and sensors."""
        return self._profile

    @property
    def features(self) -> Features:
        """What the robot can do on this backend, readable before connecting."""
        return self._features

    @property
    def health(self) -> dict[str, SensorHealth]:
        """How each sensor is, by its name; and each program that localises or drives the robot.

        What a sensor at fault delivers is not used. One that the robot needs keeps it still: a motion waits for
        up to 10 s, and goes on when the sensor is ok again.
        """
        return {sensor.name: sensor for sensor in self._runtime.health()}

    @property
    def simulation(self) -> Simulation | None:
        """The truth, in a simulated world; None on a real robot."""
        return self._simulation

    # Motions: they return why they ended, and raise only when they cannot begin

    @known_options
    async def move_to(
        self,
        x: float,
        y: float,
        theta: float | None = None,
        *,
        frame: str = "map",
        tolerance: float = 0.25,
        angle_tolerance: float = 0.1,
        timeout: float | None = None,
        on_progress: OnProgress | None = None,
    ) -> MoveResult:
        """Drives to a position, and turns to a heading where one is given.

        It aims at the goal itself; tolerances say how far off it may end where something keeps it from getting nearer.

        Args:
            x: [m] in `frame`.
            y: [m] in `frame`.
            theta: final heading [rad] in `frame`; any where left out.
            frame: `map`, `odom` or `base`.
            tolerance: [m] from the goal that counts as reached.
            angle_tolerance: [rad] from the heading that counts as reached.
            timeout: [s] of robot time; none where left out: the motion ends when it has arrived and stands, is proved
                impossible, makes no progress any more, or has no battery left.
            on_progress: called every 0.1 s of robot time with a Progress: distance left [m], time left [s], pose; what
                it raises ends the motion.

        Returns:
            The result with `success` and `reason`: `reached no_path blocked timeout cancelled estop lost uncertain
            fault`. `reached` means that the robot stands within the tolerance of its goal, wherever within its
            `position_uncertainty` it truly is.

        Raises:
            ContractError: a goal that is not finite, or an unknown frame.
            EmergencyStopError: the emergency stop is latched.
            SafetyError: another motion owns the robot.
            ConnectionError: not connected.
        """
        x, y = as_number("goal x", x), as_number("goal y", y)
        heading = None if theta is None else as_number("goal theta", theta)
        within = as_number("tolerance", tolerance)
        turned_within = as_number("angle_tolerance", angle_tolerance)
        given_in = as_text("frame", frame)

        def begin(limit: float | None) -> Motion:
            return self._runtime.move_to((x, y), heading, given_in, within, turned_within, limit)

        motion = await self._drive(begin, timeout, on_progress)
        return motion.result()

    @known_options
    async def move_forward(
        self,
        distance: float,
        *,
        tolerance: float = 0.05,
        timeout: float | None = None,
        on_progress: OnProgress | None = None,
    ) -> MoveResult:
        """Drives straight ahead by `distance` [m], backwards when negative. See `move_to`."""
        metres, within = as_number("distance", distance), as_number("tolerance", tolerance)
        motion = await self._drive(lambda t: self._runtime.move_forward(metres, within, t), timeout, on_progress)
        return motion.result()

    @known_options
    async def rotate(
        self,
        angle: float,
        *,
        angle_tolerance: float = 0.1,
        timeout: float | None = None,
        on_progress: OnProgress | None = None,
    ) -> MoveResult:
        """Turns on the spot by `angle` [rad], counter-clockwise; may exceed a full turn. See `move_to`."""
        radians, within = as_number("angle", angle), as_number("angle_tolerance", angle_tolerance)
        motion = await self._drive(lambda t: self._runtime.rotate(radians, within, t), timeout, on_progress)
        return motion.result()

    @known_options
    async def follow_path(
        self,
        path: ArrayLike | Sequence[PoseLike],
        *,
        tolerance: float = 0.25,
        timeout: float | None = None,
        on_progress: OnProgress | None = None,
    ) -> MoveResult:
        """Drives along a polyline in `map`: (N, 2) positions [m], or a list of Pose2Ds, whose headings it ignores.

        See `move_to`.
        """
        points = as_path("path", path)
        within = as_number("tolerance", tolerance)
        motion = await self._drive(lambda t: self._runtime.follow_path(points, within, t), timeout, on_progress)
        return motion.result()

    @known_options
    async def follow_waypoints(
        self,
        waypoints: ArrayLike | Sequence[PoseLike],
        *,
        tolerance: float = 0.25,
        angle_tolerance: float = 0.1,
        timeout: float | None = None,
        on_progress: OnProgress | None = None,
    ) -> MoveResult:
        """Drives to places in `map` one after the other, by whatever way, and stops at each: (N, 2) positions [m],
        (N, 3) with headings [rad], or a list in which each is a Pose2D, (x, y) or (x, y, theta).

        The first that is missed ends it: `detail` says which. `timeout` [s] is for all of them. See `move_to`.
        """
        places = as_waypoints("waypoints", waypoints)
        within = as_number("tolerance", tolerance)
        turned = as_number("angle_tolerance", angle_tolerance)
        motion = await self._drive(
            lambda t: self._runtime.follow_waypoints(places, within, turned, t), timeout, on_progress
        )
        return motion.result()

    @known_options
    async def explore(
        self, *, thorough: bool = False, timeout: float | None = None, on_progress: OnProgress | None = None
    ) -> ExploreResult:
        """Maps what can be reached, for at most `timeout` seconds of robot time. Needs a lidar.

        Ends where what is left to see is worth less than the way to it: where the unknown floor behind a frontier,
        spread along the way there, makes a strip narrower than `nav.frontier.strip`. With `thorough` the last corners
        are mapped, too, which may take as long as all the rest.
        """
        everything = as_switch("thorough", thorough)
        motion = await self._drive(lambda t: self._runtime.explore(everything, t), timeout, on_progress)
        return motion.explore_result()

    async def _drive(
        self, begin: Callable[[float | None], Motion], timeout: float | None, on_progress: OnProgress | None
    ) -> Motion:
        """Begins a motion, given its time limit, and returns it when it has ended."""
        self._time.check_waiting()
        limit = None if timeout is None else as_seconds("timeout", timeout)
        callback = None if on_progress is None else as_function("on_progress", on_progress)
        motion = begin(limit)
        await self._time.wait_for_motion(motion, callback)
        return motion

    @known_options
    async def execute_instruction(
        self,
        instruction: str,
        *,
        max_steps: int = 30,
        timeout: float = 900.0,
        model: str | None = None,
        require_vision: bool = False,
        thinking_time: float | None = None,
        max_tokens: int = 200_000,
        model_timeout: float = 120.0,
        record: str | os.PathLike[str] | None = None,
        replay: str | os.PathLike[str] | None = None,
    ) -> ExecutionResult:
        """Does what a sentence says, such as "go to the kitchen and find the red chair".

        Read by a grammar, with nothing but what the robot has seen itself: no network and no model. What is not
        understood, may mean two things, or is not allowed ends at once and says so; see `ExecutionResult.reason`.

        With a model, that is asked for one skill after the other, and gets the robot's last three pictures; the robot
        checks each call as if a person had said it. Robot time stands still while it thinks.

        Args:
            instruction: English, of at most 1,000 characters.
            max_steps: of the plan that is made of it, or answers of a model.
            timeout: [s] of robot time.
            model: address of an OpenAI-compatible server, such as `http://127.0.0.1:8080/v1`, with `#NAME` for one of
                its models; or the name of a model at OpenAI. The environment's THREEWE_MODEL where left out, and no
                model without it, or where it is "". Needs the extra `vlm`. Keys: OPENAI_API_KEY, THREEWE_MODEL_KEY for
                addresses.
            require_vision: a model that fails the eyesight test is an error, not a warning.
            thinking_time: [s] of robot time that each answer takes, however long it took; measured where left out.
            max_tokens: of a model, for the whole instruction.
            model_timeout: [s] by the wall clock, to wait for one answer.
            record: file for the conversation, without any key; pictures as hashes.
            replay: such a file: the same run again, without a server.

        Raises:
            HardwareError: it needs a camera, such as searching does, and the robot has none.
            SafetyError: another instruction or motion is in progress.
            ConfigError: no address, no key where one is needed, a record that cannot be read or is of another
                instruction, or a model that does not see where one must.
        """
        self._time.check_waiting()
        options = model_options(
            model, require_vision, thinking_time, max_tokens, model_timeout, record=record, replay=replay
        )
        instructions = self._instructed()
        if options is None:
            return await instructions.execute(instruction, max_steps, timeout)
        from threewe._model_agent import execute_with_model  # which takes a while to import

        return await execute_with_model(self, instructions, instruction, max_steps, timeout, options)

    def add_skill(self, function: SkillFunction) -> SkillFunction:
        """Adds a skill of one's own, for instructions, models and programs; may stand as a decorator.

        Args:
            function: `async def name(robot, ...)`. Its docstring says what it does; its other arguments are annotated
                `str`, `int`, `float`, `bool` or a `Literal` of texts, `... | None` where None is the default. It
                returns None, a text to answer with, or the result of a motion. What it raises ends it as `skill_error`.

        Raises ContractError for anything else, and where a skill has the name already.
        """
        self._instructed().skills.add(as_function("function", function))
        return function

    def get_skills(self) -> list[SkillInfo]:
        """The skills that instructions, models and programs may use: one list, with those that were added."""
        return self._instructed().skills.infos()

    async def execute_skill(self, skill: str, /, **arguments: object) -> ExecutionResult:
        """Executes one skill, as a model would call it: `await robot.execute_skill("search", kind="chair")`.

        It takes 900 s of robot time at most.

        Raises:
            ContractError: an unknown skill, or arguments that are not those of its schema.
            SafetyError: an instruction or a motion is in progress.
            EmergencyStopError: the emergency stop is latched.
        """
        self._time.check_waiting()
        return await self._instructed().execute_skill(as_text("skill", skill), arguments)

    def name_place(self, name: str, polygon: ArrayLike | None = None) -> None:
        """Gives a place a name, for instructions: where the robot is now, or a polygon [m] in `map`.

        A place that had the name has it no longer.

        Raises:
            ContractError: no name, `start`, or a polygon of fewer than three points or outside of the given map.
        """
        if polygon is None:
            corners = [(self.get_pose().x, self.get_pose().y)]
        else:
            corners = as_path("polygon", polygon)
            if len(corners) < 3:
                raise ContractError(f"polygon must have three points or more, got {len(corners)}")
            self._check_on_given_map(corners)
        self._instructed().agent.name_place(as_text("name", name), corners)

    def load_places(self, path: str | os.PathLike[str]) -> list[Place]:
        """Gives the places of a file their names, besides those that are known; returns them.

        Raises ConfigError with file:line for a place without a name or there twice, a polygon of fewer than three
        points, or one outside of the given map.
        """
        agent = self._instructed().agent
        places = _core.load_places(as_asset("path", path), self._given_map)
        agent.add_places(places)
        return places

    def save_places(self, path: str | os.PathLike[str]) -> None:
        """Writes the places that have names to a file that ends in .yaml, to keep beside the map.

        Raises ConfigError where it cannot be written.
        """
        _core.save_places(self.get_places(), as_asset("path", path))

    def _check_on_given_map(self, corners: list[tuple[float, float]]) -> None:
        grid = self._given_map
        if grid is None:
            return
        for x, y in corners:
            row, column = grid.cell((x, y))
            if not (0 <= row < grid.height and 0 <= column < grid.width):
                raise ContractError(f"polygon must be on the map that was given, got the point ({x:g}, {y:g})")

    def get_places(self) -> list[Place]:
        """The places that have names, in the order in which they got them."""
        return self._instructed().agent.places

    def get_things(self) -> list[MappedThing]:
        """The things that the robot has seen while it executed instructions, each from two poses or more."""
        return self._instructed().agent.things

    def _instructed(self) -> Instructions:
        self._time.check_thread()
        if self._instructions is None:
            self._instructions = Instructions(self)
        return self._instructions

    @known_options
    async def execute_action(self, action: ArrayLike, period: float = 0.02, *, creep_mode: bool = False) -> Velocity:
        """One control step: (3,) in [-1, 1], scaled to the operating limits and held for `period` [s].

        `creep_mode` is that of `set_velocity`. Returns the velocity that the safety gate let through.
        """
        self._time.check_waiting()
        vx, vy, omega = as_array("action", action, (3,)).tolist()
        creeps = as_switch("creep_mode", creep_mode)
        await self._time.wait(self._runtime.execute_action([vx, vy, omega], as_seconds("period", period), creeps))
        return self._runtime.commanded()

    # Commands that return at once

    @known_options
    def set_velocity(
        self,
        vx: float = 0.0,
        vy: float = 0.0,
        omega: float = 0.0,
        *,
        hold: float = 0.5,
        creep_mode: bool = False,
    ) -> None:
        """Drives at a body velocity [m/s, m/s, rad/s] for at most `hold` [s] of robot time, then stops.

        In `creep_mode` no corner is faster than 0.05 m/s, and the safety gate, which measures them itself, lets the
        robot pass the sides of a narrow passage with a few millimetres to spare.

        Raises:
            ContractError: a velocity that is not finite, or `vy` on a differential base.
            EmergencyStopError: the emergency stop is latched.
            SafetyError: a motion owns the robot.
        """
        vx, vy, omega = as_number("vx", vx), as_number("vy", vy), as_number("omega", omega)
        self._runtime.set_velocity(vx, vy, omega, as_seconds("hold", hold), as_switch("creep_mode", creep_mode))

    def set_zones(self, zones: Iterable[Zone]) -> None:
        """Where motions may not lead, or only slowly, in `map`; in place of what was set before.

        No path is planned into a Zone without a `speed_limit`; one with it is driven through as slowly as that, and
        planned around where that takes less time. Holds until it is called again, or a simulation is reset. What
        drives without a plan (`move_forward`, `set_velocity`) is not kept out.

        Raises:
            ContractError: a zone that is no polygon of finite corners, or whose limit is not positive.
        """
        given = as_list("zones", zones)
        for zone in given:
            if not isinstance(zone, Zone):
                raise ContractError(f"zones must hold Zones, got {zone!r}")
        self._runtime.set_zones(given)

    def stop(self) -> None:
        """Ends a motion as `cancelled` and brings the robot to a stand-still. Always allowed."""
        self._stops += 1
        self._runtime.stop()
        self._time.wake()

    def emergency_stop(self) -> None:
        """Stops at once, beyond the acceleration limit, and stays stopped. Always allowed, from any thread."""
        loop = self._time.loop
        if loop is not None and not self._time.on_own_thread():
            loop.call_soon_threadsafe(self.emergency_stop)
            return
        self._runtime.estop()
        self._time.wake()

    def release_emergency_stop(self) -> None:
        """Lets the robot move again."""
        self._runtime.release_estop()

    @property
    def emergency_stopped(self) -> bool:
        """True while the emergency stop is latched."""
        return self._runtime.estopped

    # Readings: what arrived last. They never let time go by.

    def get_lidar_scan(self) -> LaserScan:
        """The newest scan. Raises HardwareError without a lidar."""
        return self._runtime.lidar_scan()

    def get_imu(self) -> IMUData:
        """The newest reading of the inertial unit. Raises HardwareError without one."""
        return self._runtime.imu()

    def get_odometry(self) -> Odometry:
        """Where the wheels alone say that the robot is, in `odom`."""
        return self._runtime.odometry()

    def get_battery_state(self) -> BatteryState:
        """The state of the battery. Raises HardwareError without one."""
        return self._runtime.battery()

    def get_ultrasonic_ranges(self) -> dict[str, RangeData]:
        """What each ultrasonic sensor measured last, by the sensors' names. Raises HardwareError without any."""
        return self._runtime.ultrasonic_ranges()

    def get_people(self) -> list[TrackedPerson]:
        """Who walks around the robot, as its lidar sees them, in `odom`. Raises HardwareError without a lidar.

        A person who has stood for some seconds counts as an obstacle like others.
        """
        return self._runtime.people()

    def get_pose(self) -> Pose2D:
        """Where the robot believes it is, in `map`; while it is `lost`, no more than where it was last."""
        return self._runtime.pose().map_from_base

    def get_pose_covariance(self) -> NDArray[np.float64]:
        """How sure it is of that: (3, 3) covariance of x, y [m] and theta [rad], along the axes of `map`."""
        return np.array(self._runtime.pose().covariance)

    @property
    def lost(self) -> bool:
        """True while the robot does not know where it is: it looks for itself in its map, and motions wait."""
        return self._runtime.pose().lost

    @property
    def localization(self) -> str:
        """Who says where the robot is and draws its map: `slam`, `truth`, `amcl` or `slam_toolbox`."""
        return self._runtime.localization

    @property
    def navigation(self) -> str:
        """Who drives to positions and along paths: `own` or `nav2`."""
        return self._runtime.navigation

    @property
    def localization_state(self) -> LocalizationState:
        """How far the robot knows where it is; `lost` is true while it is lost or relocating."""
        return self._runtime.pose().state

    def get_velocity(self) -> Velocity:
        """The body velocity, as the robot estimates it."""
        return self._runtime.pose().velocity

    def get_transform(self, target: str, source: str) -> Pose2D:
        """`target_from_source` among `map`, `odom`, `base` and the sensors' names."""
        return self._runtime.transform(as_text("target", target), as_text("source", source))

    def get_map(self) -> OccupancyGrid:
        """The map so far: the same object until it changes, which never changes itself."""
        runtime = self._runtime
        version = runtime.map_version()
        if self._map is None or self._map[0] != version:
            self._map = version, runtime.map()
        return self._map[1]

    def save_map(self, path: str | os.PathLike[str]) -> None:
        """Writes the map so far as ROS has maps: `path`, which ends in .yaml, and the image next to it.

        Raises ConfigError where it cannot be written.
        """
        _core.save_map(self.get_map(), as_asset("path", path))

    def get_path(self) -> NDArray[np.float64]:
        """The path being followed, from the robot to its goal: (N, 2) [m] in `map`; empty between motions."""
        return np.array(self._runtime.path(), np.float64).reshape(-1, 2)

    def get_plan(self) -> SampledPlan | None:
        """The plan being followed and all the samples of which it is the weighted mean, in `odom`.

        None while no plan is followed: between motions, during turns and recoveries, on the last 0.2 m to a goal and
        without a lidar. The samples are rolled out once more when this is called, which changes nothing.
        """
        return self._runtime.plan()

    def get_camera_image(self) -> NDArray[np.uint8]:
        """The newest image of the camera: (H, W, 3) uint8, BGR; yours to draw on. See `get_image`."""
        return self.get_image("camera")

    def get_image(self, name: str = "camera") -> NDArray[np.uint8]:
        """The newest image of a camera by name: (H, W, 3) uint8, BGR; yours to draw on.

        `camera` is a level view without distortion, see `profile.camera.intrinsics`. Only real robots have the raw
        image of a lens, `fisheye`. Raises HardwareError without that camera.
        """
        return self._runtime.image(as_text("name", name)).color.copy()

    def get_rgbd_image(self) -> RGBDImage:
        """The newest image of a camera that measures depth. Raises HardwareError without one."""
        return self._runtime.rgbd_image()

    def get_observation(self) -> dict[str, NDArray[Any]]:
        """What the robot knows, as arrays: what its sensors say, and where it believes that it is.

        All are float32, as in the learning environments, but for images: `pose` (3,) in `map`, `velocity` (3,) in the
        body frame and, of the sensors that it has, `lidar` (N,) [m], `ultrasonic` (K,) [m] in the order of
        `features.sensors`, `image` (H, W, 3) uint8 BGR and `depth` (H, W) [m].
        """
        runtime = self._runtime
        estimate = runtime.pose()
        observation: dict[str, NDArray[Any]] = {
            "pose": np.array(estimate.map_from_base, np.float32),
            "velocity": np.array(estimate.velocity, np.float32),
        }
        sensors = self.features.sensors
        if any(sensor.type is SensorType.lidar for sensor in sensors):
            observation["lidar"] = runtime.lidar_scan().ranges
        if ears := [sensor.name for sensor in sensors if sensor.type is SensorType.ultrasonic]:
            ranges = runtime.ultrasonic_ranges()
            observation["ultrasonic"] = np.array([ranges[name].range for name in ears], np.float32)
        if any(sensor.type is SensorType.camera for sensor in sensors):
            image = runtime.image("camera")
            observation["image"] = image.color
            if image.depth is not None:
                observation["depth"] = image.depth
        return observation

    # Observers

    def observe(self, observer: Observer) -> int:
        """Calls `observer` with a TickView at the end of every tick (50 times a second of robot time).

        One that raises is not called any more; the error goes to the event loop's exception handler, by default the
        log. Returns a number for `unobserve`.
        """
        self._time.check_thread()
        return self._observers.add(as_function("observer", observer))

    def unobserve(self, number: int) -> None:
        """Stops calling an observer."""
        self._time.check_thread()
        self._observers.remove(as_seed("number", number))
