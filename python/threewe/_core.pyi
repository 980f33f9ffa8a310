"""
The C++ core of 3we. Use it through `threewe`, which adds what Python can do better.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
import enum
import pathlib
from typing import Annotated, Any, NoReturn, overload

import numpy
import numpy.typing
from numpy.typing import NDArray


class Pose2D:
    """
    A pose in the plane: position [m] and heading [rad] in (-pi, pi], X forward, Y left.

    A transform is a pose too: `map_from_base * base_from_lidar` is `map_from_lidar`.
    """

    def __init__(self, x: float = 0.0, y: float = 0.0, theta: float = 0.0) -> None: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def x(self) -> float:
        """[m]"""

    @property
    def y(self) -> float:
        """[m]"""

    @property
    def theta(self) -> float:
        """[rad], counter-clockwise, in (-pi, pi]"""

    def __mul__(self, b_from_c: Pose2D) -> Pose2D: ...

    def transform(self, point: tuple[float, float]) -> tuple[float, float]:
        """The point (x, y) [m] of this pose's frame, seen from outside."""

    def inverse(self) -> Pose2D:
        """`b_from_a` of `a_from_b`."""

    def distance(self, other: Pose2D) -> float:
        """Between the positions [m]."""

    def __iter__(self) -> Iterator[float]:
        """x, y, theta"""

    def __array__(self, dtype: numpy.typing.DTypeLike | None = None, *, copy: bool | None = None) -> numpy.typing.NDArray[Any]:
        """(3,) float64: x, y [m], theta [rad]"""

    def __len__(self) -> int: ...

    def __repr__(self) -> str: ...

class Velocity:
    """
    A velocity in the body frame: forward, left [m/s] and counter-clockwise [rad/s].
    """

    def __init__(self, vx: float = 0.0, vy: float = 0.0, omega: float = 0.0) -> None: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def vx(self) -> float:
        """[m/s], forward"""

    @property
    def vy(self) -> float:
        """[m/s], to the left"""

    @property
    def omega(self) -> float:
        """[rad/s], counter-clockwise"""

    def __iter__(self) -> Iterator[float]:
        """vx, vy, omega"""

    def __array__(self, dtype: numpy.typing.DTypeLike | None = None, *, copy: bool | None = None) -> numpy.typing.NDArray[Any]:
        """(3,) float64: vx, vy [m/s], omega [rad/s]"""

    def __len__(self) -> int: ...

    def __repr__(self) -> str: ...

class LaserScan:
    """
    One turn of a planar lidar.

    Beam i points along `angle_min + i * angle_increment`, counter-clockwise, in the sensor's frame, and was
    measured `i * time_increment` seconds after beam 0 (before it, where that is negative).
    """

    def __init__(self, ranges: Annotated[NDArray[numpy.float32], dict(shape=(None,), order='C', device='cpu', writable=False)], angle_min: float, angle_increment: float, range_min: float, range_max: float, time_increment: float = 0.0) -> None: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def ranges(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None,), writable=False)]:
        """(N,) float32 [m]; no return = range_max, invalid = 0.0"""

    def __array__(self, dtype: numpy.typing.DTypeLike | None = None, *, copy: bool | None = None) -> numpy.typing.NDArray[Any]:
        """`ranges`"""

    def __len__(self) -> int: ...

    def __iter__(self) -> Iterator[float]:
        """the ranges"""

    @property
    def angle_min(self) -> float:
        """[rad], of beam 0"""

    @property
    def angle_increment(self) -> float:
        """[rad], positive"""

    @property
    def time_increment(self) -> float:
        """[s], negative for a device that turns clockwise"""

    @property
    def range_min(self) -> float:
        """[m]"""

    @property
    def range_max(self) -> float:
        """[m]"""

    def __repr__(self) -> str: ...

class IMUData:
    """One reading of the inertial unit, in the robot's base frame."""

    def __init__(self, angular_velocity: Sequence[float], linear_acceleration: Sequence[float]) -> None: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    def __array__(self, *args: object, **kwargs: object) -> NoReturn: ...

    @property
    def angular_velocity(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), writable=False)]:
        """(3,) float64 [rad/s] about x, y, z"""

    @property
    def linear_acceleration(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), writable=False)]:
        """(3,) float64 [m/s^2] along x, y, z, with gravity: +9.81 on z at rest"""

    def __repr__(self) -> str: ...

class Odometry:
    """Where the wheels alone say that the robot is, and how fast it moves."""

    def __init__(self, pose: Pose2D, velocity: Velocity) -> None: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    def __array__(self, *args: object, **kwargs: object) -> NoReturn: ...

    @property
    def pose(self) -> Pose2D:
        """in the `odom` frame"""

    @property
    def velocity(self) -> Velocity:
        """in the body frame"""

    def __repr__(self) -> str: ...

class BatteryState:
    """The state of the battery."""

    def __init__(self, voltage: float, current: float, charge: float) -> None: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def voltage(self) -> float:
        """[V]"""

    @property
    def current(self) -> float:
        """[A], positive when discharging"""

    @property
    def charge(self) -> float:
        """the fraction left, 0 to 1"""

    def __repr__(self) -> str: ...

class RangeData:
    """
    One reading of a sensor that tells the distance to something within a cone, not where in it.
    """

    def __init__(self, field_of_view: float, range_min: float, range_max: float, range: float) -> None: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def field_of_view(self) -> float:
        """[rad] from edge to edge of the cone"""

    @property
    def range_min(self) -> float:
        """[m]"""

    @property
    def range_max(self) -> float:
        """[m]"""

    @property
    def range(self) -> float:
        """[m]; no return = range_max, invalid = 0.0"""

    def __repr__(self) -> str: ...

class CameraIntrinsics:
    """
    A pinhole without distortion: a point (x forward, y left, z up) of the camera's frame is seen at column
    cx - fx y / x and row cy - fy z / x; the middle of the first pixel is at (0.5, 0.5).
    """

    def __init__(self, width: int, height: int, fx: float, fy: float, cx: float, cy: float) -> None: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @staticmethod
    def of_view(width: int, height: int, horizontal_fov: float) -> CameraIntrinsics:
        """One that sees `horizontal_fov` [rad] with square pixels."""

    @property
    def width(self) -> int:
        """[px]"""

    @property
    def height(self) -> int:
        """[px]"""

    @property
    def fx(self) -> float:
        """[px]"""

    @property
    def fy(self) -> float:
        """[px]"""

    @property
    def cx(self) -> float:
        """[px]"""

    @property
    def cy(self) -> float:
        """[px]"""

    def __repr__(self) -> str: ...

class RGBDImage:
    """One image of a camera. Arrays are read-only views."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    def __array__(self, *args: object, **kwargs: object) -> NoReturn: ...

    @property
    def color(self) -> Annotated[NDArray[numpy.uint8], dict(shape=(None, None, 3), writable=False)]:
        """(H, W, 3) uint8, BGR"""

    @property
    def depth(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None, None), writable=False)] | None:
        """
        (H, W) float32 [m] along the optical axis, invalid = 0.0; None of a camera that measures none
        """

    @property
    def intrinsics(self) -> CameraIntrinsics: ...

    def __repr__(self) -> str: ...

class SemanticImage:
    """What is truly there to be seen. Arrays are read-only views."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    def __array__(self, *args: object, **kwargs: object) -> NoReturn: ...

    @property
    def color(self) -> Annotated[NDArray[numpy.uint8], dict(shape=(None, None, 3), writable=False)]:
        """(H, W, 3) uint8, BGR, without noise"""

    @property
    def depth(self) -> Annotated[NDArray[numpy.float32], dict(shape=(None, None), writable=False)]:
        """(H, W) float32 [m] along the optical axis, nothing there = 0.0"""

    @property
    def ids(self) -> Annotated[NDArray[numpy.int16], dict(shape=(None, None), writable=False)]:
        """(H, W) int16, of what each pixel shows"""

    @property
    def names(self) -> list[str]:
        """
        What ids mean, by id: nothing, floor, wall, ceiling, then objects, people and robots.
        """

    @property
    def intrinsics(self) -> CameraIntrinsics: ...

    def __repr__(self) -> str: ...

class SensorType(enum.StrEnum):
    """The kinds of sensor that the contract knows."""

    def __str__(self) -> str: ...

    lidar = 'lidar'

    imu = 'imu'

    odometry = 'odometry'

    battery = 'battery'

    ultrasonic = 'ultrasonic'

    camera = 'camera'

class Sample:
    """A reading with its stamps."""

    def __init__(self, sensor: int, sequence: int, measured: float, data: LaserScan | IMUData | Odometry | BatteryState | RangeData | RGBDImage) -> None: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def sensor(self) -> int:
        """Index into `Features.sensors`."""

    @property
    def sequence(self) -> int:
        """Counts each sensor's samples from 0, without gaps."""

    @property
    def measured(self) -> float:
        """[s] of robot time; for a scan, of beam 0 of the array"""

    @property
    def received(self) -> float:
        """[s] of robot time"""

    @property
    def data(self) -> LaserScan | IMUData | Odometry | BatteryState | RangeData | RGBDImage: ...

    def __repr__(self) -> str: ...

def active_target() -> str:
    """
    The vector instructions in use, such as AVX2. Results do not depend on it.
    """

def available_targets() -> list[str]:
    """Those that this machine can run, fastest first."""

def force_target(name: str) -> None:
    """Uses one of them, or the fastest again when `name` is empty."""

def add_asset_directory(directory: str | pathlib.Path) -> None:
    """
    Adds a folder with `scenes/`, `objects/`, `robots/` or `localization/` to those searched, as THREEWE_PATH does.
    """

def asset_directories() -> list[pathlib.Path]:
    """
    The folders that are searched: the installed one, those in THREEWE_PATH, then those added.
    """

def unknown_name(kind: str, name: str, candidates: Sequence[str]) -> str:
    """"unknown scene 'ofice_v2'; did you mean 'office_v2'?\""""

class Skill(enum.StrEnum):
    """What one step of a command does."""

    def __str__(self) -> str: ...

    move_to_place = 'move_to_place'
    """drives to `place`"""

    approach = 'approach'
    """drives to `thing`"""

    move_to = 'move_to'
    """drives to `x`, `y`, and turns to `theta` where given"""

    move_forward = 'move_forward'
    """drives `distance` straight on; backwards where negative"""

    rotate = 'rotate'
    """turns by `angle`"""

    search = 'search'
    """looks for `thing`"""

    explore = 'explore'
    """maps what is unknown; in `place` where given"""

    look = 'look'
    """turns once around to see"""

    list_things = 'list_things'
    """says which things are known; in `place` where given"""

    list_places = 'list_places'
    """says which places are known"""

    name_place = 'name_place'
    """calls the place where the robot is `name`"""

    answer = 'answer'
    """answers a question `about` `thing`, or about its own position"""

    wait = 'wait'
    """stands for `duration`"""

    follow = 'follow'
    """follows the instruction `route`, as of VLN"""

    done = 'done'
    """ends"""

class ReadingOutcome(enum.StrEnum):
    """What became of a text."""

    def __str__(self) -> str: ...

    understood = 'understood'
    """`steps` say what to do"""

    ambiguous = 'ambiguous'
    """it has several `meanings`: ask"""

    not_understood = 'not_understood'
    """`word` could not be read"""

    refused = 'refused'
    """it asks for what no robot does: `rule`"""

class RefusalRule(enum.StrEnum):
    """Why a command is refused."""

    def __str__(self) -> str: ...

    speed = 'speed'
    """it asks to be faster than the operating limits"""

    obstacle = 'obstacle'
    """it asks to drive through, over or against something"""

    emergency_stop = 'emergency_stop'
    """it asks to release the emergency stop"""

    zone = 'zone'
    """it asks to enter a keep-out zone"""

class ThingPhrase:
    """A thing as it is described. What is not said is empty."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def kind(self) -> str:
        """category of objects, such as "chair"; empty: any thing"""

    @property
    def color(self) -> str:
        """one of the eleven basic color terms, such as "red\""""

    @property
    def which(self) -> str:
        """"nearest" or "farthest\""""

    @property
    def next_to(self) -> str:
        """another thing beside it: "[color ]kind\""""

    @property
    def place(self) -> str:
        """where it is"""

    def __repr__(self) -> str: ...

class Step:
    """
    One step of a command: a skill and its arguments. What was not said is empty or None.
    """

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def skill(self) -> Skill:
        """what to do"""

    @property
    def about(self) -> str:
        """of `answer`: "exists", "where", "count" or "position\""""

    @property
    def place(self) -> str:
        """of `move_to_place`, `explore` and `list_things`"""

    @property
    def name(self) -> str:
        """of `name_place`"""

    @property
    def thing(self) -> ThingPhrase:
        """of `approach`, `search` and `answer`"""

    @property
    def x(self) -> float | None:
        """[m] of `move_to`, in `map`"""

    @property
    def y(self) -> float | None:
        """[m] of `move_to`, in `map`"""

    @property
    def theta(self) -> float | None:
        """[rad] of `move_to`, counter-clockwise from the x axis"""

    @property
    def distance(self) -> float | None:
        """[m] of `move_forward`"""

    @property
    def angle(self) -> float | None:
        """[rad] of `rotate`, counter-clockwise"""

    @property
    def duration(self) -> float | None:
        """[s] of `wait`"""

    @property
    def route(self) -> str:
        """of `follow`: the instruction"""

    @property
    def arguments(self) -> dict[str, str | float]:
        """
        What was said, by name, in canonical order; those of `thing` and its `place` among them.
        """

    def __str__(self) -> str: ...

    def __repr__(self) -> str: ...

class Reading:
    """What a text was read as. Only what its outcome names is filled."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def outcome(self) -> ReadingOutcome:
        """which of the others says more"""

    @property
    def steps(self) -> list[Step]:
        """what to do, in order, where understood"""

    @property
    def meanings(self) -> list[str]:
        """two or more where ambiguous, sorted: names of places, or plans as text"""

    @property
    def word(self) -> str:
        """the first word that could not be read where not understood, lower case"""

    @property
    def rule(self) -> RefusalRule | None:
        """why, where refused; else None"""

    def __str__(self) -> str: ...

    def __repr__(self) -> str: ...

def read_command(text: str, places: Sequence[str]) -> Reading:
    """Reads a command in English where these places are known."""

class Kinematics(enum.StrEnum):
    """How the wheels move the body."""

    def __str__(self) -> str: ...

    holonomic = 'holonomic'
    """any direction"""

    differential = 'differential'
    """ahead and turning, never sideways"""

class Limits:
    """Bounds on a body velocity and on how fast it may change."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def linear(self) -> float:
        """[m/s], of the vector (vx, vy)"""

    @property
    def angular(self) -> float:
        """[rad/s]"""

    @property
    def linear_acceleration(self) -> float:
        """[m/s^2], speeding up"""

    @property
    def linear_braking(self) -> float:
        """[m/s^2], slowing down"""

    @property
    def angular_acceleration(self) -> float:
        """[rad/s^2]"""

    def __repr__(self) -> str: ...

class LidarSpec:
    """A lidar that turns, and the scan that is made of its turn."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def base_from_lidar(self) -> Pose2D: ...

    @property
    def height(self) -> float:
        """[m] of the scan plane above the floor"""

    @property
    def points_per_turn(self) -> int:
        """measured by the device"""

    @property
    def clockwise(self) -> bool:
        """how the device turns; scans are always counter-clockwise"""

    @property
    def beams(self) -> int:
        """in the scan that is delivered"""

    @property
    def turn(self) -> float:
        """[s] of one revolution"""

    @property
    def range_min(self) -> float:
        """[m]"""

    @property
    def range_max(self) -> float:
        """[m]"""

    @property
    def sigma(self) -> float:
        """[m] of each range"""

    @property
    def latency(self) -> float:
        """[s] from the end of a turn to its arrival"""

class UltrasonicSpec:
    """Ultrasonic sensors of one kind, pinged in turn."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def mounts(self) -> dict[str, Pose2D]:
        """
        Where each sensor is, by its name, in the order in which they are pinged.
        """

    @property
    def height(self) -> float:
        """[m] of all of them above the floor"""

    @property
    def interval(self) -> float:
        """[s] from one ping to the next, of another sensor"""

    @property
    def field_of_view(self) -> float:
        """[rad] of the cone of sound, from edge to edge"""

    @property
    def max_incidence(self) -> float:
        """[rad] off a surface's normal, beyond which no sound comes back"""

    @property
    def range_min(self) -> float:
        """[m]"""

    @property
    def range_max(self) -> float:
        """[m]"""

    @property
    def sigma(self) -> float:
        """[m] of each range"""

    @property
    def latency(self) -> float:
        """[s] from a ping to the arrival of its range"""

class DepthSpec:
    """How well a camera measures depth along its optical axis."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def range_min(self) -> float:
        """[m], nearer is invalid"""

    @property
    def range_max(self) -> float:
        """[m], farther is invalid"""

    @property
    def sigma(self) -> float:
        """[m] at 1 m; it grows with the square of the depth"""

class CameraSpec:
    """A camera: what its level, rectified pinhole view shows, and how well."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def base_from_camera(self) -> Pose2D:
        """It looks along its x axis."""

    @property
    def mount_height(self) -> float:
        """[m] of its optical axis above the floor"""

    @property
    def intrinsics(self) -> CameraIntrinsics: ...

    @property
    def period(self) -> float:
        """[s] from image to image"""

    @property
    def sigma(self) -> float:
        """[levels of 255] of each pixel's colours"""

    @property
    def latency(self) -> float:
        """[s] from an image to its arrival"""

    @property
    def depth(self) -> DepthSpec | None: ...

class IMUSpec:
    """An inertial unit."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def period(self) -> float:
        """[s]"""

    @property
    def gyro_sigma(self) -> float:
        """[rad/s] of each sample"""

    @property
    def gyro_bias(self) -> float:
        """[rad/s] at most, at the start"""

    @property
    def accelerometer_sigma(self) -> float:
        """[m/s^2]"""

    @property
    def latency(self) -> float:
        """[s]"""

class BatterySpec:
    """A battery."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def capacity(self) -> float:
        """[Wh]"""

    @property
    def voltage_full(self) -> float:
        """[V]"""

    @property
    def voltage_empty(self) -> float:
        """[V]"""

    @property
    def period(self) -> float:
        """[s]"""

class AutonomyParameter:
    """A tuned number of the autonomy stack, as a robot has it."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def name(self) -> str:
        """With its module, such as `nav.recovery.same_place`."""

    @property
    def value(self) -> float:
        """In `unit`; times in seconds."""

    @property
    def unit(self) -> str:
        """Such as `m`; empty for a share or a count."""

    @property
    def reference(self) -> float:
        """
        The value of the reference robot, `3we_standard_v2`, in the profile's unit [`unit`].
        """

    @property
    def scale(self) -> str:
        """
        What it grows with from robot to robot, such as `size`; `none` where it is the same for all.
        """

    @property
    def origin(self) -> str:
        """
        `default`, the scale and its factor, or where in the profile it is overridden.
        """

    @property
    def meaning(self) -> str:
        """What it does, in a line."""

    @property
    def is_count(self) -> bool:
        """A whole number."""

    def __repr__(self) -> str: ...

class RobotProfile:
    """
    What a robot is: its body, its limits, its sensors. Sensors it lacks are None.
    """

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @staticmethod
    def load(name: str) -> RobotProfile:
        """
        Reads a profile by name, or from a file that ends in .yaml. Raises ConfigError naming the nearest right name.
        """

    @staticmethod
    def parse(yaml: str, name: str) -> RobotProfile:
        """Reads a profile from the text of such a file, as `yaml` has it."""

    def __deepcopy__(self, memo: object) -> object:
        """Itself: a profile never changes."""

    def with_image_size(self, height: int, width: int) -> RobotProfile:
        """
        The same robot, whose camera delivers pictures of another size: with the same horizontal field of view and square pixels.
        """

    @property
    def name(self) -> str: ...

    @property
    def description(self) -> str: ...

    @property
    def yaml(self) -> str:
        """The text that it was read from."""

    @property
    def kinematics(self) -> Kinematics: ...

    @property
    def footprint(self) -> list[tuple[float, float]]:
        """The corners of the outline around the base, counter-clockwise [m]."""

    @property
    def footprint_radius(self) -> float:
        """[m], of the smallest disc around the base that holds the outline"""

    @property
    def height(self) -> float:
        """[m]"""

    @property
    def mass(self) -> float:
        """[kg]"""

    def parameters(self) -> list[AutonomyParameter]:
        """
        Every parameter of the autonomy stack for this robot, module by module. Raises ConfigError where the profile's `autonomy:` section is wrong.
        """

    @property
    def hardware_limits(self) -> Limits:
        """What the drive can do."""

    @property
    def operating_limits(self) -> Limits:
        """What it is asked to do."""

    @property
    def lidar(self) -> LidarSpec | None: ...

    @property
    def imu(self) -> IMUSpec | None: ...

    @property
    def ultrasonics(self) -> UltrasonicSpec | None: ...

    @property
    def camera(self) -> CameraSpec | None: ...

    @property
    def battery(self) -> BatterySpec | None: ...

    def __repr__(self) -> str: ...

def profile_names() -> list[str]:
    """The names of all robot profiles."""

class Zone:
    """
    A polygon on the floor, in `map`, to keep out of; with a `speed_limit` to drive slowly in.
    """

    def __init__(self, corners: Sequence[tuple[float, float]], *, speed_limit: float | None = None) -> None: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def corners(self) -> list[tuple[float, float]]:
        """(x, y) [m], in order; the last is joined to the first"""

    @property
    def speed_limit(self) -> float | None:
        """[m/s] while any part of the body is in it, or None"""

    def contains(self, point: tuple[float, float]) -> bool:
        """Whether a point (x, y) [m] lies inside."""

    def __repr__(self) -> str: ...

class OccupancyGrid:
    """
    What is free, occupied and unknown, as ROS defines it: -1 unknown, 0 free to 100 occupied.

    Row-major; cell (0, 0) has its lower left corner at `origin`, axes along the map frame's.
    """

    def __init__(self, data: Annotated[NDArray[numpy.int8], dict(shape=(None, None), order='C', device='cpu', writable=False)], resolution: float = 0.05, origin: tuple[float, float] = (0.0, 0.0)) -> None: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def data(self) -> Annotated[NDArray[numpy.int8], dict(shape=(None, None), writable=False)]:
        """(H, W) int8: -1 unknown, 0 free to 100 occupied; row 0 is the lowest y"""

    def __array__(self, dtype: numpy.typing.DTypeLike | None = None, *, copy: bool | None = None) -> numpy.typing.NDArray[Any]:
        """`data`"""

    @property
    def width(self) -> int:
        """cells along x"""

    @property
    def height(self) -> int:
        """cells along y"""

    @property
    def resolution(self) -> float:
        """[m] a cell"""

    @property
    def origin(self) -> tuple[float, float]:
        """(x, y) [m] of the corner of cell (0, 0)"""

    def cell(self, point: tuple[float, float]) -> tuple[int, int]:
        """
        (row, column) of the cell that holds the point (x, y) [m]; may lie outside the grid.
        """

    def at(self, point: tuple[float, float]) -> int:
        """The value at a point (x, y) [m]; -1 outside the grid."""

    def __repr__(self) -> str: ...

def load_map(path: str) -> OccupancyGrid:
    """
    Reads a map as ROS has maps: a file that ends in .yaml, and the picture that it names.
    """

def save_map(grid: OccupancyGrid, path: str) -> None:
    """
    Writes a map as ROS has maps: `path`, which ends in .yaml, and the picture beside it.
    """

class SlamConfig:
    """What `threewe.slam.Slam` knows about the robot beforehand."""

    def __init__(self, *, base_from_lidar: Pose2D = ..., range_max: float = 30.0, resolution: float = 0.05, range_bias_sigma: float = 0.01, distance_sigma: float = 0.02, position_drift: float = 0.05, heading_drift: float = 0.15) -> None: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def base_from_lidar(self) -> Pose2D:
        """where the lidar is on the robot"""

    @property
    def range_max(self) -> float:
        """[m]; what a scan sees farther away is left out"""

    @property
    def resolution(self) -> float:
        """[m] a cell of the map"""

    @property
    def range_bias_sigma(self) -> float:
        """[m] of the lidar's constant error"""

    @property
    def distance_sigma(self) -> float:
        """share by which the odometry's distances may all be wrong"""

    @property
    def position_drift(self) -> float:
        """[m/sqrt(m)] by which the odometry's position wanders"""

    @property
    def heading_drift(self) -> float:
        """[rad/sqrt(m)] by which the odometry's heading wanders"""

def check_reading(scan: LaserScan, odometry: Pose2D) -> None:
    """
    Raises ContractError where `Slam.add` would for these numbers, whatever came before.
    """

class SlamEvent:
    """
    What was wrong with a mapper's input, from the first scan concerned to the last.
    """

    @property
    def incident(self) -> str:
        """
        lidar_frozen, odometry_jumped, odometry_stopped, odometry_scaled, track_lost or components_joined
        """

    @property
    def begin(self) -> float:
        """[s] of the first scan concerned"""

    @property
    def end(self) -> float:
        """[s] of the last one"""

    @property
    def scans(self) -> int:
        """how many are concerned"""

    def __repr__(self) -> str: ...

class Slam:
    """Mapping from scans and odometry: what `threewe.slam.Slam` is made of."""

    def __init__(self, config: SlamConfig = ...) -> None: ...

    def add(self, time: float, scan: LaserScan, odometry: Pose2D | None) -> tuple[Pose2D, list[SlamEvent]]:
        """
        One scan, measured at `time` [s]; where the robot is, and events that began.
        """

    def map(self, component: int = 0) -> OccupancyGrid:
        """The map so far, of one component."""

    def trajectory(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, 4))]:
        """(N, 4) float64: time [s], x [m], y [m], heading [rad] at each scan."""

    def components(self) -> list[int]:
        """
        The component of the pose graph that each scan belongs to; 0 is the map's.
        """

    def events(self) -> list[SlamEvent]:
        """What was wrong with the input, in order of time."""

    def closures(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, 5))]:
        """
        (N, 5) float64: earlier and later time [s], x [m], y [m], heading [rad] of the later pose seen from the earlier one.
        """

    def save(self, path: str) -> None:
        """Keeps the map in a file with all that is behind it."""

    @staticmethod
    def load(path: str, map_from_base: Pose2D | None = None) -> Slam:
        """A map that was kept, to be looked at or to go on with."""

class Prism:
    """
    A vertical prism over a rectangle or a disc, in the frame of its object.
    """

    class Shape(enum.StrEnum):
        def __str__(self) -> str: ...

        box = 'box'

        cylinder = 'cylinder'

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def shape(self) -> Prism.Shape: ...

    @property
    def pose(self) -> Pose2D:
        """of its middle"""

    @property
    def length(self) -> float:
        """[m] along x, of a box"""

    @property
    def width(self) -> float:
        """[m] along y, of a box"""

    @property
    def radius(self) -> float:
        """[m], of a cylinder"""

    @property
    def z_min(self) -> float:
        """[m]"""

    @property
    def z_max(self) -> float:
        """[m]"""

    @property
    def material(self) -> str: ...

    def outline(self) -> list[tuple[float, float]]:
        """Its corners seen from above, counter-clockwise [m]; a disc has 24."""

class Wall:
    """A straight wall of some thickness: the piece between two doorways."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def a(self) -> tuple[float, float]:
        """(x, y) [m]"""

    @property
    def b(self) -> tuple[float, float]:
        """(x, y) [m]"""

    @property
    def thickness(self) -> float:
        """[m]"""

    @property
    def height(self) -> float:
        """[m]"""

class Door:
    """A doorway in a wall."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def name(self) -> str: ...

    @property
    def center(self) -> tuple[float, float]:
        """(x, y) [m]"""

    @property
    def width(self) -> float:
        """[m]"""

class Room:
    """A named room: an axis-aligned rectangle."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def name(self) -> str: ...

    @property
    def min(self) -> tuple[float, float]:
        """(x, y) [m]"""

    @property
    def max(self) -> tuple[float, float]:
        """(x, y) [m]"""

    @property
    def floor(self) -> str:
        """its material"""

    @property
    def anchor(self) -> tuple[float, float]:
        """(x, y) [m] where a robot can stand"""

    def __repr__(self) -> str: ...

class Patch:
    """
    A patch of floor with a friction of its own: an axis-aligned rectangle.
    """

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def name(self) -> str: ...

    @property
    def min(self) -> tuple[float, float]:
        """(x, y) [m]"""

    @property
    def max(self) -> tuple[float, float]:
        """(x, y) [m]"""

    @property
    def floor(self) -> str:
        """its material"""

    @property
    def friction(self) -> float:
        """times the friction that wheels have on a hard floor"""

class Person:
    """A person who walks round and round a closed route."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def name(self) -> str: ...

    @property
    def route(self) -> list[tuple[float, float]]:
        """waypoints (x, y) [m]; after the last comes the first"""

    @property
    def speed(self) -> float:
        """[m/s]"""

    @property
    def radius(self) -> float:
        """[m]"""

class Object:
    """A piece of furniture."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def name(self) -> str:
        """unique in its scene, such as `chair_3`"""

    @property
    def category(self) -> str:
        """such as `chair`"""

    @property
    def shape(self) -> str:
        """which of the category's shapes, such as `wooden`"""

    @property
    def pose(self) -> Pose2D: ...

    @property
    def prisms(self) -> list[Prism]: ...

    def __repr__(self) -> str: ...

class Scene:
    """
    Walls, doors, named rooms and furniture. Its origin is its start pose; x along the start heading.
    """

    @staticmethod
    def load(name: str) -> Scene:
        """
        Reads a scene by name, or from a file that ends in .yaml. Raises ConfigError with file and line.
        """

    @staticmethod
    def parse(text: str, name: str) -> Scene:
        """
        Reads a scene from YAML; `name` stands for it in messages. Raises ConfigError with the line.
        """

    @staticmethod
    def generate(seed: int, *, difficulty: float = 0.5, size: tuple[float, float] = (14.0, 10.0)) -> Scene:
        """
        A building with furnished rooms, drawn from a seed: all rooms can be reached by every robot. `difficulty` 0
        to 1 is from sparse to crowded, `size` is (x, y) [m], 6 to 40 each. The same on every machine.
        """

    def __deepcopy__(self, memo: object) -> object:
        """Itself: a scene never changes."""

    def __getstate__(self) -> str: ...

    def __setstate__(self, arg: str, /) -> None: ...

    def to_yaml(self, name: str | None = None) -> str:
        """
        The scene as text, under another name if one is given: that of the file it is saved in.
        """

    @property
    def name(self) -> str: ...

    @property
    def description(self) -> str: ...

    @property
    def ceiling(self) -> bool:
        """False under the open sky."""

    @property
    def min(self) -> tuple[float, float]:
        """(x, y) [m] of the box around all walls"""

    @property
    def max(self) -> tuple[float, float]:
        """(x, y) [m]"""

    @property
    def walls(self) -> list[Wall]: ...

    @property
    def doors(self) -> list[Door]: ...

    @property
    def rooms(self) -> list[Room]: ...

    @property
    def patches(self) -> list[Patch]: ...

    @property
    def objects(self) -> list[Object]: ...

    @property
    def people(self) -> list[Person]: ...

    @property
    def starts(self) -> list[Pose2D]:
        """Where robots start; the first is the origin."""

    def room(self, name: str) -> Room:
        """A room by name. Raises ConfigError naming the nearest right one."""

    def room_at(self, point: tuple[float, float]) -> Room:
        """The room that holds a point (x, y) [m], or None."""

    def friction_at(self, point: tuple[float, float]) -> float:
        """
        How well wheels hold at a point (x, y) [m], times their friction on a hard floor.
        """

    def __repr__(self) -> str: ...

def scene_names() -> list[str]:
    """The names of all scenes."""

class Episode:
    """One task: from a pose to a place, in the scene's frame."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def start(self) -> Pose2D: ...

    @property
    def goal(self) -> tuple[float, float]:
        """(x, y) [m]"""

    @property
    def geodesic(self) -> float:
        """[m], from start to goal"""

    @property
    def seed(self) -> int:
        """for all else that is drawn in this episode"""

class SceneTables:
    """
    A scene as one robot meets it: where it can be, and how far it is from place to place.
    """

    def __init__(self, scene: Scene, profile: RobotProfile) -> None: ...

    def collides(self, pose: Pose2D) -> bool:
        """Whether the footprint touches an obstacle."""

    def clearance(self, pose: Pose2D) -> float:
        """Distance [m] between the footprint and the nearest obstacle."""

    def geodesic(self, a: tuple[float, float], b: tuple[float, float]) -> float:
        """
        Length [m] of the shortest path for the footprint; infinity where there is none.
        """

    def geodesics(self, points: Sequence[tuple[float, float]], target: tuple[float, float]) -> list[float]:
        """The same from each of many points [m], for the cost of one."""

    def sample_free_pose(self, seed: int) -> Pose2D:
        """
        A pose with 5 cm to spare around the footprint: a pure function of the seed.
        """

    def sample_episode(self, seed: int, index: int = 0) -> Episode:
        """
        Start and goal uniform over free cells, 2 to 15 m apart by the shortest path, every fifth with a detour.
        """

class CoverageMeter:
    """
    How much of a scene a robot has really seen and mapped: the share of reachable 5 cm cells that a
    noise-free ray from the true pose crossed within 8 m and that its own map marks free within 10 cm.
    """

    def __init__(self, scene: Scene, profile: RobotProfile) -> None:
        """Raises HardwareError for a robot without a lidar."""

    def observe(self, scene_from_base: Pose2D) -> None:
        """Casts 360 rays, given the base's true pose."""

    def coverage(self, grid: OccupancyGrid, scene_from_map: Pose2D = ...) -> float:
        """
        The share, 0 to 1, that was crossed and is marked free, given the robot's own map and where its frame lies.
        """

    def crossed(self) -> float:
        """The share, 0 to 1, that was crossed."""

class RecordedScan:
    """One recorded scan with the odometry and the truth at that time."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def time(self) -> float:
        """[s]"""

    @property
    def truth(self) -> Pose2D:
        """where it was, in the scene's frame"""

    @property
    def odometry(self) -> Pose2D:
        """where its wheels had it"""

    @property
    def scan(self) -> LaserScan: ...

class LogSpec:
    """
    Specification of a synthetic log, a tour through a scene, for `threewe slam synth`.
    """

    @staticmethod
    def load(name: str) -> LogSpec:
        """
        Reads a log specification by name, or from a file that ends in .yaml. Raises ConfigError with file and line.
        """

    @property
    def name(self) -> str: ...

    @property
    def description(self) -> str: ...

    @property
    def scene(self) -> Scene: ...

    @property
    def stops(self) -> list[tuple[float, float]]:
        """(x, y) [m] one after the other, in the scene's frame"""

    def drive(self, seed: int = 0) -> list[RecordedScan]:
        """
        Drives the tour with the sensors of a robot of the year 2000: 180 beams, slipping wheels, no gyro. A pure
        function of the seed. Raises ConfigError where a stop cannot be reached.
        """

def log_names() -> list[str]:
    """The names of all log specifications."""

def log_lidar() -> Pose2D:
    """Where the lidar of a recorded log's robot is."""

class SensorInfo:
    """One sensor of a robot, as it is known before connecting."""

    def __init__(self, name: str, type: SensorType, rate: float) -> None: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def name(self) -> str:
        """unique on a robot; also the name of its frame"""

    @property
    def type(self) -> SensorType: ...

    @property
    def rate(self) -> float:
        """[Hz]"""

    def __repr__(self) -> str: ...

class Features:
    """What a robot can do, readable before connecting."""

    def __init__(self, sensors: Sequence[SensorInfo], kinematics: Kinematics, *, lockstep: bool = False, deterministic: bool = False, can_reset: bool = False, can_save: bool = False) -> None: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def sensors(self) -> list[SensorInfo]: ...

    @property
    def kinematics(self) -> Kinematics: ...

    @property
    def lockstep(self) -> bool:
        """Time advances only when a caller advances it."""

    @property
    def deterministic(self) -> bool:
        """The same seed and commands give the same samples, to the bit."""

    @property
    def can_reset(self) -> bool: ...

    @property
    def can_save(self) -> bool: ...

def backend_names() -> list[str]:
    """The names of all backends."""

def use_mujoco(path: str) -> None:
    """
    Says where MuJoCo's library is; it is loaded when a world is first made.
    """

MUJOCO_VERSION: str = '4.0.0'

class BackendMailbox:
    """Between the core and the thread of a backend written in Python."""

    def __init__(self, name: str, features: Features, profile: RobotProfile, scene: Scene | None) -> None:
        """`scene` is that of a simulator which tells the truth."""

    def take(self) -> tuple[str, tuple[object, ...]] | None:
        """
        The next method to call and its arguments; None when the thread shall end.
        """

    def answer(self, answer: object | None) -> None:
        """What the method returned."""

    def fail(self, what: str) -> None:
        """What the method raised."""

    def close(self) -> None:
        """Tells the backend to disconnect and its thread to end."""

def register_backend(name: str) -> None:
    """Makes a backend of threewe.backend known to the core."""

class Outcome(enum.StrEnum):
    """How a check of a backend ended."""

    def __str__(self) -> str: ...

    passed = 'passed'

    failed = 'failed'

    not_applicable = 'not_applicable'
    """The backend does not claim the feature."""

class CheckResult:
    """What one check of a backend found."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def name(self) -> str: ...

    @property
    def outcome(self) -> Outcome: ...

    @property
    def detail(self) -> str:
        """what was wrong, or why the check does not apply; empty when passed"""

    @property
    def passed(self) -> bool:
        """False only for a failure."""

    def __repr__(self) -> str: ...

def check_names() -> list[str]:
    """The names of all checks of a backend, in the order in which they run."""

def run_check(check: str, *, backend: str, scene: str, hardware: str, noise: str, seed: int, color_ahead: str = '') -> CheckResult:
    """Runs one check on a fresh world."""

class Reason(enum.StrEnum):
    """How a motion ends, and why."""

    def __str__(self) -> str: ...

    running = 'running'
    """It has not ended."""

    reached = 'reached'
    """Success."""

    no_path = 'no_path'
    """
    No way leads there: the goal is in a wall, outside the world or cut off.
    """

    blocked = 'blocked'
    """Something in the way did not go away."""

    timeout = 'timeout'
    """Robot time ran out."""

    cancelled = 'cancelled'
    """A caller stopped it."""

    estop = 'estop'
    """The emergency stop was latched."""

    lost = 'lost'
    """The robot no longer knows where it is."""

    uncertain = 'uncertain'
    """
    By its estimate it is at its goal, but that is known less well than the tolerance asks for.
    """

    fault = 'fault'
    """The robot or its backend failed."""

    starved = 'starved'
    """The policy that steers it gave no actions any more."""

    policy_error = 'policy_error'
    """The policy that steers it raised, or gave numbers that are not finite."""

class RecoveryState(enum.StrEnum):
    """
    What a robot does that does not get on: in this order, as often as it takes or until it gives up.
    """

    def __str__(self) -> str: ...

    driving = 'driving'
    """It gets on."""

    clearing = 'clearing'
    """It stands still until what it sees is fresh."""

    backing_off = 'backing_off'
    """The way it came, or where there is most room."""

    arc_escape = 'arc_escape'
    """Where it cannot turn: out in arcs, forwards and backwards."""

    looking = 'looking'
    """It turns to look; all the way round where it is lost."""

    replanning = 'replanning'
    """It plans anew, for one period."""

    given_up = 'given_up'
    """The result's `detail` says why."""

class Progress:
    """How far a motion has come."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def distance_left(self) -> float:
        """[m] along the path; when exploring to the next frontier"""

    @property
    def time_left(self) -> float:
        """[s] that this, and turning to a heading, will take at the pace so far"""

    @property
    def distance_driven(self) -> float:
        """[m] since the start of the motion"""

    @property
    def pose(self) -> Pose2D:
        """in `map`"""

    @property
    def recovery(self) -> RecoveryState:
        """what it does that does not get on"""

    def __repr__(self) -> str: ...

class SampledPlan:
    """
    A plan, and the samples of which it is the weighted mean.

    Poses in `odom`, at the ends of the steps; velocities in the body frame, as they are asked for: the poses are where these lead within the limits of the base.
    """

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def made(self) -> float:
        """
        [s] of robot time; it begins a little later, when its first command takes effect
        """

    @property
    def step(self) -> float:
        """[s]"""

    @property
    def poses(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, 3), writable=False)]:
        """(steps, 3) where the plan leads: x, y [m], theta [rad]"""

    @property
    def velocities(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, 3), writable=False)]:
        """(steps, 3) what it asks for: vx, vy [m/s], omega [rad/s]"""

    @property
    def trajectories(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None, 3), writable=False)]:
        """(samples, steps, 3) where each sample leads, as `poses`"""

    @property
    def controls(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None, 3), writable=False)]:
        """(samples, steps, 3) what each asks for, as `velocities`"""

    @property
    def weights(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), writable=False)]:
        """(samples,) how much each counts; 1 in all"""

    def __repr__(self) -> str: ...

class TrackedPerson:
    """A person who walks, as the robot's lidar sees them. `odom` frame."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def id(self) -> int:
        """the same as long as the person is not lost sight of"""

    @property
    def position(self) -> tuple[float, float]:
        """(x, y) [m]"""

    @property
    def velocity(self) -> tuple[float, float]:
        """(vx, vy) [m/s]"""

    @property
    def covariance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(4, 4), writable=False)]:
        """(4, 4) float64, of x, y [m], vx, vy [m/s]"""

    def __repr__(self) -> str: ...

class Intervention(enum.StrEnum):
    """Why the safety gate changed a command."""

    def __str__(self) -> str: ...

    none = 'none'

    limited = 'limited'

    slowed_for_obstacle = 'slowed_for_obstacle'

    stopped_for_obstacle = 'stopped_for_obstacle'

    stale_sensors = 'stale_sensors'

    estop = 'estop'

class SensorFault(enum.StrEnum):
    """A fault of a sensor."""

    def __str__(self) -> str: ...

    none = 'none'
    """Nothing."""

    silent = 'silent'
    """Nothing has arrived for too long."""

    frozen = 'frozen'
    """The same reading again and again, while the robot moves."""

    implausible = 'implausible'
    """A reading that no such sensor can make, such as NaN."""

    wrong_stamps = 'wrong_stamps'
    """Times that run backwards, or come from the future."""

    late = 'late'
    """Readings arrive much later than they used to."""

    noisy = 'noisy'
    """Readings are noisier than they used to be."""

    shifted = 'shifted'
    """All ranges are too long or too short by the same."""

    blind = 'blind'
    """
    So many beams are invalid side by side that the robot would fit between two that are not.
    """

    contradicted = 'contradicted'
    """Other sensors say otherwise."""

class SensorHealth:
    """How one sensor is."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def name(self) -> str: ...

    @property
    def ok(self) -> bool:
        """nothing is wrong"""

    @property
    def fault(self) -> SensorFault: ...

    @property
    def detail(self) -> str:
        """says more; may be empty"""

    @property
    def since(self) -> float:
        """[s] of robot time when the fault was noticed, or was over"""

    @property
    def needed(self) -> bool:
        """the robot stands still while this sensor is at fault"""

    def __repr__(self) -> str: ...

class MoveResult:
    """How a motion ended. `map` frame."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def success(self) -> bool: ...

    @property
    def reason(self) -> Reason: ...

    @property
    def detail(self) -> str:
        """says more about a failure; may be empty"""

    @property
    def pose(self) -> Pose2D:
        """where the robot estimates that it is"""

    @property
    def position_uncertainty(self) -> float:
        """
        [m] radius around `pose` that holds the true position with 95 %, by the robot's own covariance
        """

    @property
    def distance_to_goal(self) -> float:
        """[m], by its own estimate"""

    @property
    def distance(self) -> float:
        """[m] driven, by its own estimate"""

    @property
    def duration(self) -> float:
        """[s] of robot time"""

    def raise_for_failure(self) -> None:
        """Raises the error that matches `reason`; nothing after success."""

    def __bool__(self) -> bool: ...

    def __repr__(self) -> str: ...

class ExploreResult:
    """How an exploration ended."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def success(self) -> bool:
        """nothing that can be reached is left to see"""

    @property
    def reason(self) -> Reason: ...

    @property
    def detail(self) -> str:
        """says more about a failure; may be empty"""

    @property
    def explored_area(self) -> float:
        """[m^2] known to be free"""

    @property
    def distance(self) -> float:
        """[m] driven, by its own estimate"""

    @property
    def duration(self) -> float:
        """[s] of robot time"""

    def raise_for_failure(self) -> None:
        """Raises the error that matches `reason`; nothing after success."""

    def __bool__(self) -> bool: ...

    def __repr__(self) -> str: ...

class LocalizationState(enum.StrEnum):
    """How far a robot knows where it is in its map."""

    def __str__(self) -> str: ...

    tracking = 'tracking'
    """Scans fit the map where it is estimated to be."""

    doubting = 'doubting'
    """
    They fit, but the map that was given has long been contradicted; it is searched meanwhile.
    """

    lost = 'lost'
    """They do not fit: the whole map is searched."""

    relocating = 'relocating'
    """The search found one pose; the next scans decide whether it is right."""

class PoseEstimate:
    """What is known about the robot's pose at one moment."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def stamp(self) -> float:
        """[s] of robot time"""

    @property
    def odom_from_base(self) -> Pose2D:
        """smooth: wheels and gyro, never jumps"""

    @property
    def map_from_odom(self) -> Pose2D:
        """moves when a scan or a loop closure corrects the drift"""

    @property
    def map_from_base(self) -> Pose2D: ...

    @property
    def velocity(self) -> Velocity:
        """in the body frame"""

    @property
    def covariance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3, 3), writable=False)]:
        """(3, 3) float64, of map_from_base: x, y [m], theta [rad]"""

    @property
    def state(self) -> LocalizationState: ...

    @property
    def lost(self) -> bool:
        """whether the pose is no more than where it was last"""

class TickView:
    """What an observer sees at the end of every tick."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def now(self) -> float:
        """[s] of robot time"""

    @property
    def samples(self) -> list[Sample]:
        """that arrived in this tick"""

    @property
    def pose(self) -> PoseEstimate: ...

    @property
    def requested(self) -> Velocity:
        """before the safety gate"""

    @property
    def commanded(self) -> Velocity:
        """after it"""

    @property
    def intervention(self) -> Intervention:
        """why it changed the command"""

    def __repr__(self) -> str: ...

class RobotOptions:
    """Where one robot is in a world of its own, and which."""

    def __init__(self, *, backend: str = 'mock', hardware: str = '3we_standard_v2', scene: str = 'office_v2', noise: str = 'realistic', seed: int = 0, realtime: bool = False, map: OccupancyGrid | None = None, initial_pose: Pose2D | None = None, start_pose: Pose2D | None = None, localization: str = 'slam', navigation: str = 'own', image_size: tuple[int, int] | None = None, randomization: str = 'none') -> None: ...

    @property
    def backend(self) -> str: ...

    @property
    def hardware(self) -> str: ...

    @property
    def scene(self) -> str: ...

    @property
    def noise(self) -> str: ...

    @property
    def seed(self) -> int: ...

    @property
    def realtime(self) -> bool: ...

    @property
    def map(self) -> OccupancyGrid: ...

    @property
    def initial_pose(self) -> Pose2D | None:
        """in its `map` frame"""

    @property
    def start_pose(self) -> Pose2D | None:
        """in the scene's frame"""

    @property
    def localization(self) -> str: ...

    @property
    def navigation(self) -> str: ...

    @property
    def image_size(self) -> tuple[int, int] | None:
        """(height, width) [px]"""

    @property
    def randomization(self) -> str: ...

class WorldOptions:
    """How a world of several robots is made."""

    def __init__(self, *, backend: str = 'mock', scene: str = 'office_v2', robots: Sequence[str] = ['3we_standard_v2'], noise: str = 'realistic', seed: int = 0, realtime: bool = False, start_poses: Sequence[Pose2D] = [], initial_poses: Sequence[Pose2D] = [], map: OccupancyGrid | None = None, randomization: str = 'none') -> None: ...

class Wait:
    """Something that becomes true at a tick."""

    @property
    def done(self) -> bool: ...

    @property
    def deadline(self) -> float:
        """[s] when it was due"""

    @property
    def creation(self) -> int:
        """counts the waits of one world"""

class Motion(Wait):
    """A motion in progress."""

    @property
    def progress(self) -> Progress: ...

    def cancel(self) -> None:
        """Ends it with `cancelled` and commands zero in the next period."""

    def result(self) -> MoveResult: ...

    def explore_result(self) -> ExploreResult: ...

class Snapshot:
    """Everything the future of a world depends on."""

    def __repr__(self) -> str: ...

class World:
    """
    A backend world with a runtime for each of its robots. One thread at a time may use it.
    """

    @overload
    def __init__(self, options: WorldOptions) -> None: ...

    @overload
    def __init__(self, robot: RobotOptions) -> None:
        """The world of one robot."""

    @property
    def robot_count(self) -> int: ...

    @property
    def simulated(self) -> bool:
        """whether it has a `Simulation`"""

    def robot(self, index: int) -> Runtime: ...

    @property
    def now(self) -> float:
        """[s] of robot time"""

    def disconnect(self) -> None:
        """Stops every robot and lets go of it."""

    def tick(self) -> None:
        """One control period."""

    def run(self, wall: float) -> bool:
        """
        Ticks until a wait is done, none is pending, or `wall` seconds have passed. True when a wait was done.
        """

    def sleep(self, seconds: float) -> Wait: ...

    def alarm(self, seconds: float) -> Wait: ...

    def forget(self, wait: Wait) -> None: ...

    def take_finished(self) -> list[Wait]: ...

    def has_pending(self) -> bool: ...

    @property
    def realtime(self) -> bool: ...

    def due(self) -> float:
        """[wall s] until the next tick is due"""

    def open_hold(self) -> None: ...

    def close_hold(self, charge: float) -> Wait: ...

    @property
    def held(self) -> bool: ...

    def save(self) -> Snapshot: ...

    def claim_thread(self) -> None:
        """
        The calling thread alone may use it and its robots, until `release_thread`.
        """

    def release_thread(self) -> None:
        """
        Any thread may be the next. For the owner, or for any caller once its event loop is closed.
        """

class Runtime:
    """One robot of a world: autonomy stack, gate and port."""

    def connect(self) -> None: ...

    def disconnect(self) -> None: ...

    @property
    def connected(self) -> bool: ...

    def ready(self) -> Wait: ...

    @property
    def fault(self) -> str: ...

    @property
    def profile(self) -> RobotProfile: ...

    @property
    def features(self) -> Features: ...

    @property
    def localization(self) -> str: ...

    @property
    def navigation(self) -> str: ...

    def lidar_scan(self) -> LaserScan: ...

    def imu(self) -> IMUData: ...

    def odometry(self) -> Odometry: ...

    def battery(self) -> BatteryState: ...

    def image(self, camera: str) -> RGBDImage: ...

    def image_measured(self) -> float: ...

    def rgbd_image(self) -> RGBDImage: ...

    def people(self) -> list[TrackedPerson]: ...

    def health(self) -> list[SensorHealth]: ...

    def ultrasonic_ranges(self) -> dict[str, RangeData]: ...

    def sample(self, type: SensorType) -> Sample: ...

    def pose(self) -> PoseEstimate: ...

    def map(self) -> OccupancyGrid: ...

    def map_version(self) -> int: ...

    def path(self) -> list[tuple[float, float]]: ...

    def plan(self) -> SampledPlan | None: ...

    def transform(self, target: str, source: str) -> Pose2D: ...

    def commanded(self) -> Velocity: ...

    def set_velocity(self, vx: float, vy: float, omega: float, hold: float, creep_mode: bool) -> None: ...

    def execute_action(self, action: Sequence[float], period: float, creep_mode: bool) -> Wait: ...

    def stop(self) -> None: ...

    def set_zones(self, zones: Sequence[Zone]) -> None: ...

    def estop(self) -> None: ...

    def release_estop(self) -> None: ...

    @property
    def estopped(self) -> bool: ...

    def observe(self, observer: Callable[[TickView], None]) -> int: ...

    def unobserve(self, id: int) -> None: ...

    def motion(self) -> Motion: ...

    def move_to(self, goal: tuple[float, float], theta: float | None, frame: str, tolerance: float, angle_tolerance: float, timeout: float | None) -> Motion:
        """`goal` [m] and `theta` [rad] in `frame`."""

    def drive(self, source: Callable[[float], tuple[Velocity, Reason, str]], timeout: float | None) -> Motion:
        """
        `source(now)` [s] gives the velocity that it wants in each control period, a reason that ends the motion or `running`, and a detail.
        """

    def move_forward(self, distance: float, tolerance: float, timeout: float | None) -> Motion: ...

    def rotate(self, angle: float, angle_tolerance: float, timeout: float | None) -> Motion: ...

    def follow_path(self, path: Sequence[tuple[float, float]], tolerance: float, timeout: float | None) -> Motion: ...

    def follow_waypoints(self, places: Sequence[tuple[float, float, float | None]], tolerance: float, angle_tolerance: float, timeout: float | None) -> Motion: ...

    def explore(self, thorough: bool, timeout: float | None) -> Motion: ...

class PersonPose:
    """Where a person of a simulated scene is."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def name(self) -> str: ...

    @property
    def pose(self) -> Pose2D:
        """in the scene's frame, facing the way they walk or wait to walk"""

    @property
    def radius(self) -> float:
        """[m] of the circle that they fill on the floor"""

    def __repr__(self) -> str: ...

class Simulation:
    """
    The truth about a robot in a simulated world, for metrics, drawings and training.

    All poses are in the scene's frame. Robots never see it.
    """

    def __init__(self, world: World, robot: int) -> None: ...

    @property
    def scene(self) -> Scene: ...

    def true_pose(self) -> Pose2D: ...

    def true_velocity(self) -> Velocity:
        """In the body frame."""

    def start_pose(self) -> Pose2D:
        """
        Where the robot stood at the last reset: the origin of its `map` frame.
        """

    @property
    def scene_from_map(self) -> Pose2D:
        """
        Where the origin of the robot's map truly is. A perfect map drifts from it in nothing.

        Unknown for a given map without an `initial_pose`, which is taken for one of the scene, origin and all.
        """

    def max_collision_speed(self) -> float:
        """
        The fastest approach [m/s] of the robot's own motion into an obstacle since the last reset.
        """

    def distance_driven(self) -> float:
        """[m] since the last reset."""

    def people(self) -> list[PersonPose]:
        """The people of the scene, where they are and which way they walk."""

    def sample_free_pose(self, seed: int) -> Pose2D:
        """
        A pose where the robot fits with 5 cm to spare: a pure function of the seed.
        """

    def geodesic(self, a: tuple[float, float], b: tuple[float, float]) -> float:
        """
        Length [m] of the shortest path between (x, y) points for the robot's footprint; infinity where there is none.
        """

    def teleport(self, pose: Pose2D) -> None:
        """
        A person lifts the robot and puts it down at a pose; its autonomy stack gets no notice.
        """

    def look(self, intrinsics: CameraIntrinsics, pose: Pose2D, height: float, with_itself: bool) -> SemanticImage:
        """
        What a level camera at a pose and a height [m] above the floor would truly show now, with or without the robot itself.
        """

    def reset(self, *, seed: int | None = None, pose: Pose2D | None = None, episode: int = 0) -> None:
        """
        Begins anew at time 0, with the world's own seed and at the scene's own start pose unless said otherwise; all noise is that of an episode of the seed.

        Raises ConfigError when that is inside an obstacle.
        """

    def save(self) -> Snapshot:
        """
        Everything the future depends on. Raises ContractError while a motion is in progress.
        """

    def restore(self, snapshot: Snapshot) -> None:
        """Goes on from where `save` was called."""

class RecordingFrame:
    """One camera image on its way into a journal."""

    @property
    def robot(self) -> int:
        """its number among those recorded"""

    @property
    def sensor(self) -> int:
        """its number among the robot's sensors"""

    @property
    def color(self) -> Annotated[NDArray[numpy.uint8], dict(shape=(None, None, 3), writable=False)]:
        """(H, W, 3) uint8, BGR; drawn on first access"""

class Recorder:
    """Crash-safe journal of what robots sense, are asked for and do."""

    def __init__(self, world: World, folder: str, robots: Sequence[int], sensors: Sequence[str], encoder: bool) -> None: ...

    def start_episode(self, task: str, metadata: Mapping[str, bool | int | float | str]) -> int: ...

    def end_episode(self, success: bool | None, metadata: Mapping[str, bool | int | float | str]) -> None: ...

    def close(self) -> None: ...

    def discard_episode(self) -> None: ...

    @property
    def recording(self) -> bool: ...

    @property
    def ticks(self) -> int: ...

    def record_step(self, robot: int, action: Sequence[float]) -> None: ...

    def set_instruction(self, robot: int, instruction: str) -> None: ...

    def set_takeover(self, robot: int, takeover: bool) -> None: ...

    def next_frame(self) -> RecordingFrame | None: ...

    def put_packet(self, frame: RecordingFrame, packet: bytes) -> None: ...

    def put_raw(self, frame: RecordingFrame) -> None: ...

    def detach_encoder(self) -> None: ...

class RecordedFrame:
    """Where the image of a camera sample is in its journal."""

    @property
    def sensor(self) -> int: ...

    @property
    def measured(self) -> float:
        """[s]"""

    @property
    def received(self) -> float:
        """[s]"""

    @property
    def width(self) -> int:
        """[px]"""

    @property
    def height(self) -> int:
        """[px]"""

    @property
    def encoded(self) -> bool:
        """as an H.264 access unit; raw otherwise"""

    @property
    def has_depth(self) -> bool: ...

class RecordedRobot:
    """One robot of a recorded episode."""

    @property
    def profile(self) -> str: ...

    @property
    def hardware(self) -> str:
        """the profile's YAML; empty where that was made in code"""

    @property
    def scene_from_map(self) -> Pose2D | None: ...

    @property
    def sensors(self) -> list[SensorInfo]: ...

    @property
    def cameras(self) -> list[CameraIntrinsics]:
        """by the sensors' numbers; without pixels where it is no camera"""

    @property
    def samples(self) -> list[Sample]:
        """in order of arrival; a camera's hold no image"""

    @property
    def frames(self) -> list[RecordedFrame]: ...

    @property
    def time(self) -> NDArray[numpy.float64]: ...

    @property
    def simulated(self) -> bool: ...

    @property
    def intervention(self) -> NDArray[numpy.uint8]: ...

    @property
    def lost(self) -> NDArray[numpy.bool_]: ...

    @property
    def takeover(self) -> NDArray[numpy.bool_]: ...

    @property
    def step_time(self) -> NDArray[numpy.float64]: ...

    @property
    def step_action(self) -> NDArray[numpy.float64]: ...

    @property
    def instructions(self) -> list[tuple[float, str]]: ...

    @property
    def pose(self) -> NDArray[numpy.float64]: ...

    @property
    def odom_from_base(self) -> NDArray[numpy.float64]: ...

    @property
    def true_pose(self) -> NDArray[numpy.float64]: ...

    @property
    def velocity(self) -> NDArray[numpy.float64]: ...

    @property
    def requested(self) -> NDArray[numpy.float64]: ...

    @property
    def executed(self) -> NDArray[numpy.float64]: ...

    @property
    def true_velocity(self) -> NDArray[numpy.float64]: ...

class ReplayReport:
    """How far a replay came from what was recorded."""

    @property
    def ticks(self) -> int: ...

    @property
    def max_deviation(self) -> float:
        """[m] between true positions"""

    @property
    def first_difference(self) -> float | None:
        """[s] of any bit of a true pose or a sample"""

class WorldOrigin:
    """Of which backend a world is, and how it was made."""

    @property
    def backend(self) -> str: ...

    @property
    def scene(self) -> str: ...

    @property
    def robots(self) -> list[str]: ...

    @property
    def seed(self) -> int: ...

    @property
    def randomization(self) -> str: ...

class Journal:
    """One recorded episode, read from its file."""

    @staticmethod
    def open(file: str) -> Journal: ...

    @property
    def episode(self) -> int: ...

    @property
    def task(self) -> str: ...

    @property
    def success(self) -> bool | None: ...

    @property
    def metadata(self) -> dict[str, bool | int | float | str]: ...

    @property
    def recovered(self) -> bool: ...

    @property
    def started(self) -> float:
        """wall clock [s since 1970]"""

    @property
    def began(self) -> float:
        """[s] of robot time"""

    @property
    def robots(self) -> list[RecordedRobot]: ...

    @property
    def origin(self) -> WorldOrigin | None: ...

    @property
    def can_replay(self) -> bool: ...

    def color(self, frame: RecordedFrame) -> bytes:
        """An access unit, or (H, W, 3) blue, green, red."""

    def depth(self, frame: RecordedFrame) -> NDArray[numpy.uint16]:
        """(H, W) uint16 [mm], 0 where invalid."""

    def replay(self) -> ReplayReport:
        """Makes its world anew and sends the commands that were executed."""

class Recovered:
    """What was made of a journal that a crash had cut off."""

    @property
    def file(self) -> pathlib.Path:
        """empty where nothing of it could be saved"""

    @property
    def ticks(self) -> int: ...

    @property
    def lost_bytes(self) -> int: ...

class JournalHeader:
    """What a journal says at its beginning."""

    @property
    def episode(self) -> int: ...

    @property
    def task(self) -> str: ...

    @property
    def robots(self) -> list[str]:
        """the names of their hardware profiles"""

def read_journal_header(journal: str) -> JournalHeader:
    """Reads no more of a journal, however long it is."""

def recover_journals(folder: str) -> list[Recovered]: ...

def journals(folder: str) -> list[pathlib.Path]: ...

class Detection:
    """One thing in a picture."""

    @property
    def color(self) -> str:
        """the basic color term of most of what is seen of it"""

    @property
    def colors(self) -> dict[str, float]:
        """
        by the names of the basic color terms that it has, the share of each in what is seen of it
        """

    @property
    def kind_index(self) -> int:
        """index into the detector's labels"""

    @property
    def scores(self) -> list[float]:
        """(labels,) probability of each label"""

    @property
    def confidence(self) -> float:
        """0 to 1, that it is of its kind"""

    @property
    def box(self) -> list[int]:
        """[px] x and y from, x and y to (excluded)"""

    @property
    def cells(self) -> int:
        """how many cells of 1/40 of the view's width show it"""

    @property
    def bearing(self) -> float:
        """[rad] from the camera's axis to its centre, to the left"""

    @property
    def distance(self) -> float:
        """[m] along the camera's axis to its centre"""

class Detector:
    """Object detector in integer arithmetic: the same bits on every machine."""

    @staticmethod
    def load(name: str = 'indoor_v1') -> Detector:
        """
        Reads one that is shipped, or a file that ends in .safetensors. Raises ConfigError.
        """

    @staticmethod
    def of_boxes(layout: BoxLayout, find: Callable[..., object]) -> Detector:
        """
        One of a function that is given a picture, and returns (N, 4 + labels) float32: boxes [px] and scores.
        """

    @property
    def labels(self) -> list[str]:
        """what it can tell apart; the first is the background"""

    @property
    def radii(self) -> list[float]:
        """[m] of the circle that things of each label usually fit in"""

    @property
    def description(self) -> str:
        """what it was trained on"""

    def detect(self, picture: Annotated[NDArray[numpy.uint8], dict(shape=(None, None, 3), order='C', device='cpu', writable=False)], camera: CameraIntrinsics) -> list[Detection]:
        """
        The things in a (H, W, 3) uint8 BGR picture of a level camera, largest first. Raises ContractError.
        """

class BoxLayout:
    """What the outputs of a network mean that finds boxes in pictures."""

    @staticmethod
    def load(path: str) -> BoxLayout:
        """Reads a YAML file. Raises ConfigError with file:line."""

    @property
    def labels(self) -> list[str]:
        """in the order of the network's scores; empty: not used"""

    @property
    def radii(self) -> list[float]:
        """[m]"""

    @property
    def rgb(self) -> bool:
        """order of the input's channels; else BGR"""

    @property
    def scale(self) -> float:
        """by which pixels are divided first"""

    @property
    def mean(self) -> list[float]:
        """of each channel after that, which is taken away"""

    @property
    def deviation(self) -> list[float]:
        """by which it is divided then"""

    @property
    def centers(self) -> bool:
        """boxes are centre and size; else two corners"""

    @property
    def confidence(self) -> float:
        """least score of a box"""

    @property
    def overlap(self) -> float:
        """above which two boxes are of one thing"""

def color_names() -> list[str]:
    """The eleven basic color terms."""

def color_of(blue: int, green: int, red: int) -> str:
    """The color term of a pixel, each of 0 to 255."""

class ActionTimeline:
    """
    Chunks of actions in robot time: merged, interpolated, braked at their end.
    """

    def __init__(self, limits: Limits, rate: float, chunk: int, merge: str) -> None: ...

    def add(self, measured: float, actions: Annotated[NDArray[numpy.float64], dict(shape=(None, 3), order='C', device='cpu', writable=False)], now: float) -> None:
        """
        Merges in (chunk, 3) [m/s, m/s, rad/s] made from a picture of `measured` [s]. Raises ContractError.
        """

    def next(self, now: float) -> Velocity:
        """The velocity of the control tick at `now` [s]."""

    def planned(self, time: float) -> Velocity | None:
        """
        The velocity that the control tick at `time` [s], now or later, will have; None beyond the end.
        """

    @property
    def end(self) -> float | None:
        """[s] of robot time; None before any chunk"""

    @property
    def applied(self) -> int:
        """chunks merged in"""

    @property
    def late(self) -> int:
        """chunks that came after their end"""

    @property
    def jumps(self) -> int:
        """
        chunks that changed the velocity by more than one period's acceleration
        """

class PolicyRecovery:
    """Moves a robot away from what the gate has stopped a policy for."""

    def __init__(self, profile: RobotProfile) -> None: ...

    def next(self, now: float, wanted: Velocity, stopped: bool, scan: LaserScan | None) -> Velocity:
        """
        What to ask of the gate in the control tick at `now` [s]; `stopped`: in the one before it let nothing through.
        """

    @property
    def count(self) -> int:
        """how often it moved away"""

class Inference:
    """One run of a graph in a thread of its own, which needs no Python."""

    def done(self) -> bool:
        """Whether there is a result or an error."""

    def wait(self, seconds: float) -> bool:
        """Waits for it so long [s] at most; whether it is done."""

    def result(self) -> Annotated[NDArray[numpy.float32], dict(order='C')]:
        """
        The graph's output, float32. Raises what went wrong, TimeoutError before.
        """

class GraphSession:
    """A policy's graph on one thread, by onnxruntime's library."""

    def __init__(self, library: str, graph: bytes, inputs: Sequence[tuple[str, Sequence[int]]], output: tuple[str, Sequence[int]]) -> None: ...

    def run(self, inputs: list[object]) -> Annotated[NDArray[numpy.float32], dict(order='C')]:
        """
        The output for inputs in their order: float32 arrays, or (image, height, width, rgb) of pictures.
        """

    def start(self, inputs: list[object]) -> Inference:
        """The same in a thread of its own."""

def network_input(image: Annotated[NDArray[numpy.uint8], dict(shape=(None, None, 3), order='C', device='cpu', writable=False)], height: int, width: int, rgb: bool) -> Annotated[NDArray[numpy.float32], dict(order='C')]:
    """
    (1, 3, height, width) 0 to 1 of a BGR picture, each pixel the mean of those that it stands for.
    """

def instruction_embedding(text: str) -> list[float]:
    """(64,) of a sentence, as in `3we/VLN-v1`."""

class MappedThing:
    """A thing that the robot has seen, perhaps many times."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def id(self) -> int:
        """grows with every new one"""

    @property
    def position(self) -> tuple[float, float]:
        """[m] of its centre, in `map`"""

    @property
    def covariance(self) -> list[float]:
        """[m^2] of the position: xx, xy, yy"""

    @property
    def kinds(self) -> list[float]:
        """probability of each of the detector's labels"""

    @property
    def views(self) -> int:
        """from different poses"""

    @property
    def kind_index(self) -> int:
        """its most probable kind, index into the detector's labels"""

    @property
    def color(self) -> str:
        """the color term that most of it has"""

    @property
    def colors(self) -> dict[str, float]:
        """
        by the names of the basic color terms that it has, the share of each in all that was seen of it
        """

class Place:
    """A place that has a name."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def name(self) -> str: ...

    @property
    def polygon(self) -> list[tuple[float, float]]:
        """[m] in `map`; one point where the robot stood as it was named"""

    @property
    def origin(self) -> str:
        """`given` by users, or `seen`: probably so by what stands there"""

    def contains(self, point: tuple[float, float]) -> bool:
        """
        Whether a point [m] in `map` is in it, or within 2.5 m of one that is a point.
        """

class ExecutedStep:
    """One skill that was executed."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def skill(self) -> str:
        """such as `search`"""

    @property
    def text(self) -> str:
        """with its arguments: `search(kind=chair, color=red)`"""

    @property
    def arguments(self) -> dict[str, str | float]:
        """those that were said: [m], [rad] or [s] where they are numbers"""

    @property
    def reason(self) -> str:
        """how it ended: `done`, `not_found`, or a motion's reason"""

    @property
    def detail(self) -> str:
        """says more; may be empty"""

    @property
    def begun(self) -> float:
        """[s] of robot time"""

    @property
    def ended(self) -> float:
        """[s] of robot time"""

    @property
    def thing(self) -> int:
        """id of the mapped thing that it rests on; 0: none"""

    @property
    def verified(self) -> bool:
        """the robot's own detector saw what it says"""

    def __repr__(self) -> str: ...

class ExecutionResult:
    """What became of an instruction."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def success(self) -> bool:
        """`reason` is `done`"""

    @property
    def reason(self) -> str:
        """
        done, not_found, not_understood, ambiguous, refused, budget, or a motion's reason
        """

    @property
    def detail(self) -> str:
        """says more about a failure; may be empty"""

    @property
    def answer(self) -> str:
        """to a question, or what was found, as a sentence; may be empty"""

    @property
    def verified(self) -> bool:
        """the robot's own detector saw what the answer says"""

    @property
    def steps(self) -> list[ExecutedStep]:
        """the skills that were executed"""

    @property
    def distance(self) -> float:
        """[m] driven, by its own estimate"""

    @property
    def duration(self) -> float:
        """[s] of robot time"""

    def __repr__(self) -> str: ...

class Agent:
    """
    Executes instructions on one robot. Use it through `Robot.execute_instruction`.
    """

    def __init__(self, robot: Runtime, detector: Detector) -> None: ...

    def begin(self, instruction: str, steps: int, duration: float) -> None: ...

    def update(self) -> None: ...

    def cancel(self) -> None: ...

    @property
    def done(self) -> bool: ...

    @property
    def steps(self) -> list[ExecutedStep]:
        """those begun so far; the last may have no `reason` yet"""

    @property
    def result(self) -> ExecutionResult: ...

    @property
    def look_period(self) -> float:
        """[s] of robot time between two looks"""

    def sees(self, thing: int) -> bool:
        """Whether the newest look shows a thing of the map, by its id."""

    @property
    def things(self) -> list[MappedThing]: ...

    @property
    def places(self) -> list[Place]: ...

    @property
    def labels(self) -> list[str]: ...

    def add_places(self, places: Sequence[Place]) -> None: ...

    def name_place(self, name: str, polygon: Sequence[tuple[float, float]]) -> None: ...

def load_places(path: str, within: OccupancyGrid | None) -> list[Place]:
    """
    Reads a places file. Raises ConfigError, also for a place that is not on the map `within`.
    """

def save_places(places: Sequence[Place], path: str) -> None:
    """Writes a places file, whose name ends in .yaml."""

def places_of_scene(scene: Scene) -> list[Place]:
    """
    The rooms of a scene as places, in its frame, by the names that people call them.
    """

class Randomization:
    """Domain randomisation: how far robots differ from their profile."""

    @staticmethod
    def load(name: str) -> Randomization:
        """
        Reads one by name, or from a file that ends in .yaml. Raises ConfigError with file and line.
        """

    @staticmethod
    def parse(text: str, name: str) -> Randomization: ...

    def draw(self, seed: int) -> dict[str, float]:
        """
        How the robot differs in the episode of a seed: every knob's value, those that are not drawn as they are without randomisation.
        """

    @property
    def name(self) -> str: ...

    @property
    def description(self) -> str: ...

def randomization_names() -> list[str]:
    """The names of all randomisations."""

def knob_names() -> list[str]:
    """The names of all numbers that a randomisation can draw."""

class TopView:
    """A world from above, in the scene's frame: for pictures."""

    @property
    def robots(self) -> list[Pose2D]: ...

    @property
    def hits(self) -> list[list[tuple[float, float]]]:
        """[m] what each robot's newest scan hit"""

    @property
    def people(self) -> list[tuple[float, float, float]]:
        """x, y and radius [m] of each"""

    @property
    def goals(self) -> list[tuple[float, float]]:
        """of each robot; empty without goals"""

    @property
    def ground(self) -> Annotated[NDArray[numpy.uint8], dict(shape=(None, None), writable=False)]:
        """
        (H, W) uint8, row 0 the lowest y: 0 what needs not be seen, 1 what is still to be, 2 what has been; (0, 0) where nothing needs be
        """

    @property
    def ground_origin(self) -> tuple[float, float]: ...

    @property
    def ground_resolution(self) -> float: ...

class EpisodeInfo:
    """A world's episode."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def seed(self) -> int: ...

    @property
    def episode(self) -> int:
        """counted from 0 since the seed was given"""

    @property
    def scene(self) -> int:
        """place in the list of scenes"""

    @property
    def steps(self) -> int:
        """taken"""

class ObservationField:
    """An array that every robot observes."""

    @property
    def name(self) -> str: ...

    @property
    def shape(self) -> list[int]: ...

    @property
    def low(self) -> float: ...

    @property
    def high(self) -> float: ...

    @property
    def dtype(self) -> str: ...

class EnvBatch:
    """
    Many environments at once. Arrays are views of C++ memory, one row for each robot, which every call of `reset` and `step` overwrites.
    """

    def __init__(self, *, task: str, scenes: Sequence[Scene], hardware: RobotProfile, noise: str, observations: Sequence[str] | None, lidar_beams: int, image_size: tuple[int, int], localization: str, localization_model: str, randomization: Randomization, gate: str | None, max_steps: int, control_period: float, num_envs: int, num_robots: int, num_threads: int, autoreset: str, episodes: str, goal_frame: str, stop: bool, contact: str) -> None: ...

    def reset(self, seeds: Sequence[int | None], episodes: Sequence[int | None], scenes: Sequence[int | None], start: Pose2D | None, goal: tuple[float, float] | None, category: str | None, mask: Sequence[bool]) -> None: ...

    @property
    def final_observations(self) -> dict[str, Any]: ...

    @property
    def ended(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,))]: ...

    @property
    def done(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,))]: ...

    @property
    def final_metrics(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

    @property
    def fields(self) -> list[ObservationField]:
        """What every robot observes, in order."""

    def step(self, actions: Annotated[NDArray[numpy.float32], dict(shape=(None, 3), order='C', device='cpu', writable=False)]) -> None: ...

    @property
    def observations(self) -> dict[str, Any]: ...

    @property
    def rewards(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

    @property
    def terminated(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,))]: ...

    @property
    def truncated(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,))]: ...

    @property
    def metric_names(self) -> list[str]: ...

    @property
    def metrics(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

    @property
    def true_poses(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

    @property
    def scan_ages(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

    def variation(self, env: int, robot: int = 0) -> dict[str, float]:
        """How a robot differs from its profile now: the value of each knob."""

    @property
    def instruction_name(self) -> str:
        """What `instruction` is called; empty where a task has none."""

    def instruction(self, env: int) -> str:
        """What an episode is about: an instruction, a category."""

    def episode(self, env: int) -> EpisodeInfo: ...

    def top_view(self, env: int) -> TopView: ...

class RobotEnv:
    """
    One environment around a robot of any backend. As EnvBatch with one environment.
    """

    def __init__(self, *, backend: str, task: str, scenes: Sequence[str], hardware: str, noise: str, observations: Sequence[str] | None, lidar_beams: int, image_size: tuple[int, int], localization: str, randomization: str, gate: str | None, max_steps: int, control_period: float, episodes: str, goal_frame: str, stop: bool, contact: str) -> None: ...

    @property
    def scenes(self) -> list[Scene]:
        """As the backend has them."""

    @property
    def hardware(self) -> RobotProfile:
        """As the backend has it."""

    @property
    def map(self) -> OccupancyGrid:
        """The robot's own map in the first scene."""

    def reset(self, seeds: Sequence[int | None], episodes: Sequence[int | None], scenes: Sequence[int | None], start: Pose2D | None, goal: tuple[float, float] | None, category: str | None, mask: Sequence[bool]) -> None: ...

    @property
    def fields(self) -> list[ObservationField]:
        """What every robot observes, in order."""

    def step(self, actions: Annotated[NDArray[numpy.float32], dict(shape=(None, 3), order='C', device='cpu', writable=False)]) -> None: ...

    @property
    def observations(self) -> dict[str, Any]: ...

    @property
    def rewards(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

    @property
    def terminated(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,))]: ...

    @property
    def truncated(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,))]: ...

    @property
    def metric_names(self) -> list[str]: ...

    @property
    def metrics(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

    @property
    def true_poses(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

    @property
    def scan_ages(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

    def variation(self, env: int, robot: int = 0) -> dict[str, float]:
        """How a robot differs from its profile now: the value of each knob."""

    @property
    def instruction_name(self) -> str:
        """What `instruction` is called; empty where a task has none."""

    def instruction(self, env: int) -> str:
        """What an episode is about: an instruction, a category."""

    def episode(self, env: int) -> EpisodeInfo: ...

    def top_view(self, env: int) -> TopView: ...

class TrueDrive:
    """A drive tick by tick (20 ms), from robot time 0. Privileged."""

    def __len__(self) -> int:
        """ticks"""

    @property
    def commands(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, 3))]:
        """(N, 3) that left the gate [m/s, m/s, rad/s], body frame"""

    @property
    def poses(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, 3))]:
        """(N, 3) true poses x, y [m], theta [rad] in the scene's frame"""

    @property
    def length(self) -> float:
        """[m] driven"""

    @property
    def collision_speed(self) -> float:
        """[m/s] of the fastest contact"""

    def contacts(self, tables: SceneTables) -> int:
        """How often the body came to touch walls or furniture."""

class DriveLog(TrueDrive):
    """Logs the robot of a simulated world at every tick. Privileged."""

    @overload
    def __init__(self, world: World) -> None: ...

    @overload
    def __init__(self, env: RobotEnv) -> None: ...

    def end(self) -> None:
        """What follows is not logged."""

class Replay(TrueDrive):
    """
    A drive again: its commands, below autonomy and gate, in a world made anew.
    """

    def __init__(self, robot: RobotOptions, commands: Annotated[NDArray[numpy.float64], dict(shape=(None, 3), order='C', device='cpu', writable=False)]) -> None:
        """
        `commands`: (N, 3) [m/s, m/s, rad/s], one a tick. Raises ContractError for what the base cannot drive.
        """

class ObjectNavEpisode:
    """One search for something of a kind."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def start(self) -> Pose2D:
        """in the scene's frame"""

    @property
    def category(self) -> str: ...

    @property
    def geodesic(self) -> float:
        """[m], from start to the nearest place of success"""

    @property
    def seed(self) -> int:
        """for all else that is drawn in this episode"""

class ObjectNav:
    """
    What can be looked for in a scene, and from where STOP is right. Privileged.
    """

    def __init__(self, tables: SceneTables, profile: RobotProfile) -> None:
        """Raises HardwareError for a robot without a camera."""

    @property
    def goals(self) -> list[str]:
        """the kinds that can be looked for here"""

    def sample(self, seed: int, index: int = 0, category: str = '') -> ObjectNavEpisode:
        """
        Episode `index` of a seed. Raises ConfigError for a kind that is not among the goals.
        """

    def sample_in_sight(self, seed: int, index: int = 0, category: str = '') -> ObjectNavEpisode:
        """
        The same with something of the kind in sight, and nothing of it nearer than 1.5 m. Raises ConfigError where there is no such start.
        """

    def in_sight(self, base: Pose2D) -> list[str]:
        """
        The kinds of which the camera shows something at most 5 m away, as large and as little hidden as success asks for.
        """

    def distance(self, category: str, base: tuple[float, float]) -> float:
        """[m] to the nearest place of success; infinity without one."""

    def found(self, profile: RobotProfile, category: str, drive: TrueDrive) -> list[str]:
        """
        The names of the things that make STOP right where a drive has come to; none where it is wrong.
        """

class VlnEpisode:
    """One instruction to be followed."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def start(self) -> Pose2D:
        """in the scene's frame"""

    @property
    def end(self) -> tuple[float, float]:
        """where the instruction ends, in the scene's frame"""

    @property
    def instruction(self) -> str: ...

    @property
    def geodesic(self) -> float:
        """[m], from start to end"""

    @property
    def seed(self) -> int:
        """for all else that is drawn in this episode"""

class Vln:
    """Instructions of a scene, and where STOP is right. Privileged."""

    def __init__(self, tables: SceneTables) -> None:
        """Raises ConfigError for a scene in which there is nowhere to go."""

    @property
    def rooms(self) -> list[str]:
        """what its rooms are called"""

    def sample(self, seed: int, index: int = 0) -> VlnEpisode: ...

    def is_success(self, episode: VlnEpisode, position: tuple[float, float]) -> bool:
        """Whether STOP is right where the robot is."""

class ReferenceDrive:
    """A drive as it could have been."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def reached(self) -> bool: ...

    @property
    def length(self) -> float:
        """[m]"""

    @property
    def duration(self) -> float:
        """[s] at the speed limit"""

    def __repr__(self) -> str: ...

class ReferenceExploration:
    """An exploration as it could have been."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def coverage(self) -> float:
        """the share, 0 to 1, of what can be reached"""

    @property
    def length(self) -> float:
        """[m]"""

    @property
    def duration(self) -> float:
        """[s] at the speed limit, until no frontier is left"""

    def __repr__(self) -> str: ...

def spl(success: bool, shortest: float, driven: float) -> float:
    """
    Success weighted by path length (Anderson et al. 2018): 0 for a failure, else the shortest length over the
    one driven, at most 1; 1 for a success where the shortest length is 0. Lengths in [m].
    """

def optimistic_replanning(tables: SceneTables, profile: RobotProfile, start: Pose2D, goal: tuple[float, float]) -> ReferenceDrive:
    """
    A drive to `goal` [m] in a place of which nothing is known at first, as no robot can expect to beat it: with a perfect
    pose and a lidar without noise, along shortest paths for the inscribed radius through all that is not known
    to be an obstacle. `start` and `goal` (x, y) in the scene's frame. Raises HardwareError without a lidar,
    ContractError for a place outside of the scene.
    """

def nearest_frontier(tables: SceneTables, profile: RobotProfile, start: Pose2D) -> ReferenceExploration:
    """
    An exploration to the nearest frontier (Yamauchi 1997), again and again until none can be reached: with a
    perfect pose and a lidar without noise, along shortest paths. Raises HardwareError without a lidar, ContractError for a
    start outside of the scene.
    """

def export_files(scene: Scene, robot: RobotProfile, format: str, folder: str) -> list[pathlib.Path]:
    """
    Writes a scene, and a robot at its first start, into a folder; returns the files. Formats: mjcf, urdf, sdf, usd, map. Raises ConfigError for another format, and for a folder that cannot be written.
    """

class VelocityProfile(enum.StrEnum):
    """How fast commands change."""

    def __str__(self) -> str: ...

    operating = 'operating'
    """within the operating limits, as whatever drives a robot makes them"""

    hardware = 'hardware'
    """within what the profile says that the drive can do"""

    abrupt = 'abrupt'
    """at once: wheels slip"""

class Figure:
    """One figure of a profile, as it was fitted."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def name(self) -> str:
        """of its field below `body`"""

    @property
    def before(self) -> float:
        """in the profile's unit: in the profile, or what follows from it"""

    @property
    def value(self) -> float:
        """fitted, in the profile's unit"""

    @property
    def spread(self) -> float:
        """half of its 95 % interval, in the profile's unit"""

    @property
    def identifiable(self) -> bool:
        """
        Whether the excitation sequences say more about it than was assumed beforehand.
        """

    def __repr__(self) -> str: ...

class Deviation:
    """
    How far the embedded simulator's motion is from another robot's: shares.
    """

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def linear(self) -> float:
        """
        share, of (vx, vy): root mean square of the difference over that of the other's velocity
        """

    @property
    def angular(self) -> float:
        """share, the same of omega"""

    @property
    def combined(self) -> float:
        """share, the same of both, weighed as kinetic energy weighs them"""

    @property
    def pose(self) -> float:
        """
        share of the distance driven, how far apart they end: mean over all sequences
        """

    @property
    def farthest_pose(self) -> float:
        """share, the worst of them"""

    def __repr__(self) -> str: ...

class Calibration:
    """What came of `threewe.calibrate`."""

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

    @property
    def profile(self) -> RobotProfile:
        """the fitted one"""

    @property
    def figures(self) -> list[Figure]:
        """what was fitted"""

    @property
    def source(self) -> str:
        """
        "truth" where a simulator tells how its body moves, "sensors" where wheels and gyro do
        """

    @property
    def seconds(self) -> float:
        """[s] of robot time driven"""

    @property
    def before(self) -> Deviation:
        """of the sequences, by the profile as it was; their poses mean little"""

    @property
    def after(self) -> Deviation:
        """the same by the fitted one"""

def calibrate(backend: str, hardware: str) -> Calibration:
    """Drives the standard excitation sequences and fits the profile to them."""

def calibrated_yaml(hardware: str, calibration: Calibration) -> str:
    """The profile as a file, with the fitted figures in place of its own."""

def deviations(backend: str, hardware: str, profiles: Sequence[RobotProfile], seed: int, count: int, velocity_profile: VelocityProfile) -> list[Deviation]:
    """
    How far the embedded simulator with each profile is from a backend with `hardware`, on random sequences of 10 s.
    """

def repeatability(backend: str, hardware: str, seed: int, count: int, velocity_profile: VelocityProfile) -> Deviation:
    """
    How far a backend is from itself, when wheels have turned a little before the same random sequences.
    """

class Ros2Server:
    """Simulated robots as nodes of ROS 2."""

    def run(self, wall: float) -> None:
        """Serves for a time [wall s]."""

    @property
    def now(self) -> float:
        """Robot time [s]."""

def ros2_serve(*, scene: str, robots: Sequence[str], namespaces: Sequence[str], noise: str = 'realistic', seed: int = 0, speed: float = 1.0, lockstep: bool = False, map: bool = False, autonomy: bool = False) -> Ros2Server:
    """
    Makes a simulated world and serves its robots, each in a namespace such as `/robot_1`; empty for none.
    """

class Ros2Endpoint:
    """One publisher or subscription of the ROS 2 graph."""

    @property
    def publishes(self) -> bool:
        """Or subscribes."""

    @property
    def topic(self) -> str: ...

    @property
    def type(self) -> str:
        """Empty where it is none of ROS 2."""

    @property
    def hash(self) -> str:
        """`RIHS01_...`; empty where it has none, as in Humble and on micro-ROS."""

    @property
    def reliable(self) -> bool: ...

    @property
    def transient_local(self) -> bool: ...

    @property
    def rate(self) -> float:
        """
        [Hz] of its topic's messages; 0 where fewer than two came, or their type is not known.
        """

    @property
    def node(self) -> str:
        """`/namespace/name`; empty where it has not been said."""

    def __repr__(self) -> str: ...

class Ros2Graph:
    """The ROS 2 graph as it was found."""

    @property
    def endpoints(self) -> list[Ros2Endpoint]: ...

    @property
    def silence(self) -> str:
        """What was seen, and what to try, where there is no endpoint."""

def ros2_discover(wall: float) -> Ros2Graph:
    """
    Every endpoint of the ROS 2 graph that is found within a time [wall s].
    """

class Ros2TopicUse:
    """What a robot's link would use of a topic."""

    @property
    def topic(self) -> str: ...

    @property
    def type(self) -> str: ...

    @property
    def sensor(self) -> str:
        """That it would be used for, or `command`; empty for none."""

    @property
    def reason(self) -> str:
        """Why it is not used."""

class Ros2LinkProposal:
    """A `link:` section made of topics that were discovered."""

    @property
    def topics(self) -> list[Ros2TopicUse]: ...

    @property
    def missing(self) -> list[str]:
        """Sensors without a topic, and `command`."""

    @property
    def yaml(self) -> str: ...

def ros2_propose_link(profile: RobotProfile, endpoints: Sequence[Ros2Endpoint]) -> Ros2LinkProposal:
    """Which topics a robot of a profile would use."""

def ros2_distributions_with(type: str, hash: str) -> list[str]:
    """The distributions in which a type has this hash."""

def ros2_message_types() -> list[str]:
    """The names of all ROS 2 messages that we know."""

def ros2_type_hash(type: str, distribution: str) -> str:
    """The hash of a message's type, `RIHS01_...`, as a distribution has it."""

def ros2_recode(type: str, distribution: str, payload: bytes) -> bytes:
    """
    Reads a message from CDR and writes it again, little-endian. Raises ContractError where it cannot be read.
    """
