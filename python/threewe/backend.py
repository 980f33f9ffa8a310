"""Backends written in Python.

A backend is what stands between 3we and one robot, real or simulated: it takes a velocity and gives readings. Derive
from `Backend`, register the class, and every program runs on it:

    threewe.register_backend("toy", ToyBackend)
    async with Robot(backend="toy") as robot: ...

A package registers its backends by entry points instead, so that no import is needed:

    [project.entry-points."threewe.backends"]
    toy = "toy_package:ToyBackend"

`threewe.testing.check_backend("toy")` tells whether it keeps the contract.

A backend runs in a thread of its own, and 3we trusts it with nothing: one that raises, answers what breaks the
contract, or does not come back within 2 s (in real time: before its command expires) stops its robot and ends a motion
as `fault`; `connect` makes a new attempt. It may block and call any library, but no speed figure of ours applies to it:
other busy Python threads can cost it 5 ms a period.
"""

from __future__ import annotations

import atexit
import importlib.metadata
import importlib.util
import inspect
import logging
import math
import threading
import traceback
import weakref
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from threewe import _core
from threewe._arguments import as_function, as_text
from threewe._core import Features, Pose2D, Randomization, RobotProfile, Scene, SensorType, Velocity
from threewe.errors import ConfigError, ContractError

logger = logging.getLogger("threewe")

ENTRY_POINTS = "threewe.backends"
"""The entry-point group of other people's backends."""
SECONDS_TO_END = 2.0
"""[wall s] that a backend has for disconnecting when Python exits."""


@dataclass(frozen=True)
class BackendOptions:
    """What the user asked for. A real robot has no use for most of it."""

    scene: str = "office_v2"
    """The place to simulate."""
    hardware: str = "3we_standard_v2"
    """The robot profile: a name, or a file that ends in .yaml."""
    noise: str = "realistic"
    """`realistic` or `ideal`."""
    seed: int = 0
    """Of all noise."""
    start_pose: Pose2D | None = None
    """Where a simulated robot starts in its scene; the scene's own start where None."""
    image_size: tuple[int, int] | None = None
    """(height, width) [px] of what the camera is to deliver; as the profile states where None."""
    randomization: str = "none"
    """How a simulated robot differs from its profile: a name, or a file that ends in .yaml. Anything but `none` comes
    only to a backend that sets `can_randomize`; `Backend.draw_variation` draws from it."""


@dataclass(frozen=True, kw_only=True)
class Truth:
    """What a simulator knows about its robot now, and no robot does. Poses are in the scene's frame."""

    start: Pose2D | Sequence[float] | NDArray[np.floating]
    """(x, y, theta) [m, m, rad] where it stood at the last reset"""
    pose: Pose2D | Sequence[float] | NDArray[np.floating]
    """(x, y, theta) [m, m, rad]"""
    velocity: Velocity | Sequence[float] | NDArray[np.floating]
    """(vx, vy, omega) [m/s, m/s, rad/s] in the body frame"""
    distance_driven: float
    """[m] since the last reset"""
    max_collision_speed: float = 0.0
    """The fastest approach [m/s] of the robot's own motion into an obstacle since the last reset."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Reading:
    """One measurement."""

    type: ClassVar[SensorType]
    sensor: str
    """Its name in `Features.sensors`."""
    measured: float
    """[s] of robot time; rises from reading to reading of a sensor, and is never in the future."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LidarReading(Reading):
    """One turn of the lidar, as many beams as the profile has, spread evenly over the turn, counter-clockwise."""

    type: ClassVar[SensorType] = SensorType.lidar
    sensor: str = "lidar"
    ranges: NDArray[np.float32]
    """(N,) float32 [m]; no return = the profile's range_max, invalid = 0.0"""
    angle_min: float = -math.pi
    """[rad] where beam 0 points; 0 is forward."""
    time_increment: float = 0.0
    """[s] from beam to beam; negative for a device that turns clockwise, 0 for a scan taken at one time."""


@dataclass(frozen=True, kw_only=True, eq=False)
class IMUReading(Reading):
    """The inertial unit, in the robot's base frame."""

    type: ClassVar[SensorType] = SensorType.imu
    sensor: str = "imu"
    angular_velocity: Sequence[float] | NDArray[np.floating]
    """(3,) [rad/s] about x, y, z"""
    linear_acceleration: Sequence[float] | NDArray[np.floating]
    """(3,) [m/s^2] along x, y, z, with gravity: +9.81 on z at rest"""


@dataclass(frozen=True, kw_only=True, eq=False)
class OdometryReading(Reading):
    """Where the wheels say that the robot is: at the origin when it was connected first or reset."""

    type: ClassVar[SensorType] = SensorType.odometry
    sensor: str = "odometry"
    pose: Pose2D | Sequence[float] | NDArray[np.floating]
    """(x, y, theta) [m, m, rad], theta in (-pi, pi]"""
    velocity: Velocity | Sequence[float] | NDArray[np.floating]
    """(vx, vy, omega) [m/s, m/s, rad/s] in the body frame"""


@dataclass(frozen=True, kw_only=True, eq=False)
class BatteryReading(Reading):
    """The battery."""

    type: ClassVar[SensorType] = SensorType.battery
    sensor: str = "battery"
    voltage: float
    """[V]"""
    current: float
    """[A], positive when discharging"""
    charge: float
    """The fraction left, 0 to 1."""


@dataclass(frozen=True, kw_only=True, eq=False)
class UltrasonicReading(Reading):
    """One ping of one ultrasonic sensor: `sensor` is its name in the profile."""

    type: ClassVar[SensorType] = SensorType.ultrasonic
    range: float
    """[m]; no return = the profile's range_max, invalid = 0.0"""


@dataclass(frozen=True, kw_only=True, eq=False)
class CameraReading(Reading):
    """One image of the camera, of the size that the profile states."""

    type: ClassVar[SensorType] = SensorType.camera
    sensor: str = "camera"
    color: NDArray[np.uint8]
    """(H, W, 3), BGR."""
    depth: NDArray[np.float32] | None = None
    """(H, W) [m] along the optical axis, invalid = 0.0; None of a camera that measures none."""


class Backend(ABC):
    """One robot, from 3we's side. All of its methods are called by one thread, one at a time."""

    can_randomize: ClassVar[bool] = False
    """Whether it obeys `options.randomization`. `Robot(randomization=...)` is refused where it does not say so."""

    def __init__(self, options: BackendOptions) -> None:
        """Must not touch the hardware: `connect` does."""
        self.options = options
        self.profile = RobotProfile.load(options.hardware)
        """What the robot is; known before connecting. Replace it where the robot brings its own."""
        self._randomization = Randomization.load(options.randomization)
        if options.image_size is not None:
            self.profile = self.profile.with_image_size(*options.image_size)

    def draw_variation(self, seed: int) -> dict[str, float]:
        """How the robot of an episode differs from its profile, by `options.randomization`: the same for the same seed.

        Names and units are those of the files in assets/randomization: `mass` 1.1 is a robot heavier by a tenth. Draw
        at the start, with `options.seed`, and at each reset with its seed.
        """
        return self._randomization.draw(seed)

    @property
    @abstractmethod
    def features(self) -> Features:
        """What the robot can do: its sensors with their rates, and what else of the below holds. Never changes.

        `lockstep`: time advances only when `step` is asked to; else it is the wall clock.
        `deterministic`: the same seed and velocities give the same readings, to the bit.
        `can_reset`, `can_save`: the methods are there.
        """

    @abstractmethod
    def connect(self) -> None:
        """Reaches the robot, or raises. It stands still until `step` says otherwise."""

    @abstractmethod
    def disconnect(self) -> None:
        """Stops the robot and lets go of it. Called after anything went wrong, too."""

    @abstractmethod
    def step(self, t: float, velocity: Velocity) -> Iterable[Reading]:
        """Drives at `velocity`, and gives the readings that have arrived since the last step, oldest first.

        In lockstep it simulates until robot time `t` [s]; readings are measured at `t` or before. In real time it is
        called every 20 ms, `t` is now, and it should return at once. `velocity` is finite, within the hardware limits,
        without vy on a differential base, and zero as soon as a command has expired.
        """

    def reset(self, seed: int, pose: Pose2D | None) -> None:
        """Begins anew at time 0, at `pose` in the scene or at its own start."""
        raise NotImplementedError

    @property
    def scene(self) -> Scene:
        """Where a simulated robot is. Asked once, of a backend that defines `truth`."""
        return Scene.load(self.options.scene)

    def truth(self) -> Truth:
        """Where a simulated robot truly is, for `Robot.simulation`, metrics and learning environments."""
        raise NotImplementedError

    def save(self) -> bytes:
        """Everything that the future depends on."""
        raise NotImplementedError

    def restore(self, state: bytes) -> None:
        """Goes on from where `save` was called."""
        raise NotImplementedError


BackendBase = Backend
"""The same class, as the paper on 3we names it."""

BackendFactory = Callable[[BackendOptions], Backend]

_factories: dict[str, BackendFactory] = {}
_running: weakref.WeakKeyDictionary[threading.Thread, _core.BackendMailbox] = weakref.WeakKeyDictionary()


def register_backend(name: str, factory: BackendFactory) -> None:
    """Makes a backend known as `Robot(backend=name)`. Registering a name again replaces it.

    Args:
        name: as users type it.
        factory: makes the backend from BackendOptions; most often the class itself.
    """
    _factories[as_text("name", name)] = as_function("factory", factory)
    _core.register_backend(name)


def backend_names() -> list[str]:
    """The names of all backends: our own, registered ones, and those of installed packages."""
    _discover()
    return _core.backend_names()


def known_backend(name: str) -> str:
    """Looks for `name` among the backends of installed packages, unless it is known already. Returns it."""
    if name not in _core.backend_names():
        _discover()
    if name == "mujoco":
        _find_mujoco()
    return name


def _find_mujoco() -> None:
    """Tells the core where MuJoCo's package has its library; nothing of it is imported."""
    package = importlib.util.find_spec("mujoco")
    if package and package.origin:
        library = Path(package.origin).with_name(f"libmujoco.so.{_core.MUJOCO_VERSION}")
        if library.exists():
            _core.use_mujoco(str(library))


def _discover() -> None:
    """Makes known what installed packages offer; their code is imported when it is used."""
    for point in importlib.metadata.entry_points(group=ENTRY_POINTS):
        if point.name not in _core.backend_names():
            register_backend(point.name, _Imported(point))


@dataclass(frozen=True)
class _Imported:
    """A factory that is imported when it is called."""

    point: importlib.metadata.EntryPoint

    def __call__(self, options: BackendOptions) -> Backend:
        try:
            factory = self.point.load()
        except Exception as error:
            package = self.point.dist.name if self.point.dist else "an unknown package"
            raise ConfigError(f"backend '{self.point.name}' of {package} cannot be imported: {error!r}") from error
        backend: Backend = factory(options)
        return backend


def _open(
    name: str,
    scene: str,
    hardware: str,
    noise: str,
    seed: int,
    start_pose: Pose2D | None,
    image_size: tuple[int, int] | None,
    randomization: str,
) -> _core.BackendMailbox:
    """Makes a backend and starts its thread. Called by the core when a world is made."""
    options = BackendOptions(scene, hardware, noise, seed, start_pose, image_size, randomization)
    backend = _factories[name](options)
    if not isinstance(backend, Backend):
        raise ContractError(
            f"backend '{name}': its factory made a {type(backend).__name__}, not a threewe.backend.Backend"
        )
    if randomization != "none" and not backend.can_randomize:
        raise ConfigError(
            f"randomization is '{randomization}', but backend '{name}' does not say that it can randomize "
            f"(can_randomize = True in {type(backend).__name__}); it must be 'none'"
        )
    features, profile = backend.features, backend.profile
    if not isinstance(features, Features):
        raise ContractError(f"backend '{name}': features must be threewe.Features, got {type(features).__name__}")
    if not isinstance(profile, RobotProfile):
        raise ContractError(f"backend '{name}': profile must be a threewe.RobotProfile, got {type(profile).__name__}")
    for claimed, methods in [(features.can_reset, ["reset"]), (features.can_save, ["save", "restore"])]:
        for method in methods:
            if claimed and getattr(type(backend), method) is getattr(Backend, method):
                raise ContractError(f"backend '{name}': its features promise {method}(), which it does not define")

    simulated = type(backend).truth is not Backend.truth
    mailbox = _core.BackendMailbox(name, features, profile, backend.scene if simulated else None)
    thread = threading.Thread(target=_serve, args=(backend, mailbox), name=f"backend {name}", daemon=True)
    _running[thread] = mailbox
    thread.start()
    return mailbox


def _serve(backend: Backend, mailbox: _core.BackendMailbox) -> None:
    """The thread of a backend: does what the core asks for, until its world is gone."""
    while (request := mailbox.take()) is not None:
        method, arguments = request
        try:
            answer = getattr(backend, method)(*arguments)
            if inspect.isgenerator(answer):  # its code runs here, and not while the answer is being checked
                answer = list(answer)
        except BaseException as error:
            logger.exception("%s.%s() raised", type(backend).__name__, method)
            mailbox.fail(_describe(error))
        else:
            mailbox.answer(answer)


def _describe(error: BaseException) -> str:
    """`ValueError: no such port (robot.py:42)`."""
    where = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})"


@atexit.register
def _end_all() -> None:
    """Lets every robot be stopped before Python is gone."""
    running = list(_running.items())
    for _, mailbox in running:
        mailbox.close()
    for thread, _ in running:
        thread.join(SECONDS_TO_END)
