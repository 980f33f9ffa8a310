"""What a backend written in Python may do wrong: each thing its own clear error or `fault`, and the robot stands."""

from __future__ import annotations

import asyncio
import subprocess
import sys
import threading
import time
import weakref
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import threewe
from threewe import (
    ConfigError,
    ConnectionError,
    ContractError,
    Features,
    HardwareError,
    Kinematics,
    Reason,
    Robot,
    SensorInfo,
    SensorType,
    Velocity,
)
from threewe.backend import Backend, BackendOptions, LidarReading, OdometryReading, Reading, UltrasonicReading

from .toy_backend import QuietBackend

Spoil = Callable[[list[Any]], Any]


def run(program: Any) -> Any:
    return asyncio.run(program)


def register(name: str, backend: Callable[[BackendOptions], Any]) -> list[Any]:
    """Registers a backend; the list will hold those that were made."""
    made: list[Any] = []

    def factory(options: BackendOptions) -> Any:
        made.append(backend(options))
        return made[-1]

    threewe.register_backend(name, factory)
    return made


def answers(spoil: Spoil) -> type[Backend]:
    """A backend whose readings, after half a second, are what `spoil` makes of the honest ones."""

    class Spoiled(QuietBackend):
        def readings(self, t: float, velocity: Velocity) -> Any:
            honest = super().readings(t, velocity)
            return spoil(honest) if t > 0.5 else honest

    return Spoiled


async def fault_while_driving(name: str) -> tuple[Any, str]:
    """Drives until the backend is at fault: the result of the motion, and what a call says then."""
    async with Robot(backend=name) as robot:
        result = await robot.move_forward(3.0)
        with pytest.raises(ConnectionError) as error:
            robot.set_velocity(0.1, 0.0, 0.0)
        return result, str(error.value)


def test_a_backend_drives_and_is_stopped() -> None:
    made = register("quiet", QuietBackend)

    async def program() -> None:
        async with Robot(backend="quiet") as robot:
            assert robot.simulation is None
            result = await robot.move_forward(1.0)
            assert result.reason == Reason.reached
            assert abs(made[0].pose.x - 1.0) < 0.1

    run(program())
    assert made[0].disconnected == 1
    assert made[0].velocities[-1] == Velocity()


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda _: None, "step() must return a list of readings, got NoneType"),
        (lambda _: 3, "step() must return a list of readings, got int"),
        (lambda r: [*r, {"sensor": "imu"}], "step() must return readings such as OdometryReading, got one dict"),
        (lambda r: [replace(r[0], ranges=r[0].ranges.astype(float))], "'lidar': ranges has dtype float64"),
        (lambda r: [replace(r[0], ranges=list(r[0].ranges))], "ranges must be a numpy array of float32, got list"),
        (lambda r: [replace(r[0], ranges=r[0].ranges[:-1])], "'lidar': ranges has shape (359,)"),
        (lambda r: [replace(r[0], ranges=r[0].ranges.reshape(2, -1))], "'lidar': ranges has shape (2, 180)"),
        (lambda r: [replace(r[0], ranges=r[0].ranges * np.float32(np.nan))], "'lidar': ranges [0] is nan"),
        (lambda r: [replace(r[0], ranges=r[0].ranges * 2)], "'lidar': ranges [0] is 24"),
        (lambda r: [replace(r[0], angle_min="left")], "'lidar': angle_min must be a number, got str"),
        (lambda r: [replace(r[0], time_increment=float("inf"))], "'lidar': time_increment is inf"),
        (lambda r: [replace(r[1], angular_velocity=(0.0, 0.0))], "'imu': angular_velocity must be 3 numbers, got 2"),
        (lambda r: [replace(r[1], angular_velocity=0.1)], "'imu': angular_velocity must be 3 numbers, got float"),
        (
            lambda r: [replace(r[1], linear_acceleration=np.zeros((3, 1)))],
            "'imu': linear_acceleration has shape (3, 1); it must be (3,)",
        ),
        (
            lambda r: [replace(r[1], linear_acceleration=(0.0, None, 9.81))],
            "'imu': linear_acceleration must be a number, got NoneType",
        ),
        (lambda r: [replace(r[2], pose=(0.0, float("nan"), 0.0))], "'odometry': pose is nan"),
        (lambda r: [replace(r[2], pose=(0.0, 0.0, 4.0))], "'odometry': pose has a heading of 4"),
        (lambda r: [replace(r[2], velocity="fast")], "'odometry': velocity must be 3 numbers, got 4"),
        (lambda r: [replace(r[2], measured=None)], "'odometry': measured must be a number, got NoneType"),
        (lambda r: [replace(r[2], measured=float("nan"))], "'odometry': measured is nan"),
        (lambda r: [replace(r[2], measured=r[2].measured + 1.0)], "in the future"),
        (lambda r: [replace(r[2], measured=1763900000.0)], "which is probably wall-clock time; it must be robot time"),
        (lambda r: [replace(r[2], measured=r[2].measured + 5e4)], "it is probably another clock's time"),
        (lambda r: [replace(r[2], measured=float("nan"))], "measured is nan; it must be a finite number of seconds"),
        (lambda r: [replace(r[2], measured=0.1)], "'odometry': measured is 0.1 s, not after"),
        (lambda r: [r[2], r[2]], "'odometry': measured is"),
        (lambda r: [replace(r[2], sensor="odometri")], "unknown sensor 'odometri'; did you mean 'odometry'?"),
        (lambda r: [replace(r[2], sensor="imu")], "sensor 'imu': another kind of data than it measures"),
        (lambda r: [replace(r[2], sensor=7)], "the name of a sensor must be a str, got int"),
    ],
)  # fmt: skip
def test_a_wrong_answer_is_one_error_that_names_sensor_and_field(spoil: Spoil, message: str) -> None:
    made = register("wrong", answers(spoil))
    result, error = run(fault_while_driving("wrong"))
    assert result.reason == Reason.fault
    assert message in result.detail
    assert result.detail.startswith("backend 'wrong': ")
    assert message in error
    end(made[0])


def end(backend: Any) -> None:
    """Waits for the thread of the backend to have disconnected it."""
    assert backend.gone.wait(60)
    assert backend.disconnected == 1


def test_a_step_that_raises_ends_the_motion_as_fault_and_says_where() -> None:
    class Broken(QuietBackend):
        def readings(self, t: float, velocity: Velocity) -> list[Reading]:
            if t > 0.5:
                raise OSError("the serial port is gone")
            return super().readings(t, velocity)

    made = register("broken", Broken)
    result, error = run(fault_while_driving("broken"))
    assert result.reason == Reason.fault
    assert "step() raised OSError: the serial port is gone (test_plugin.py:" in result.detail
    assert "the serial port is gone" in error
    with pytest.raises(HardwareError, match="the serial port is gone"):
        result.raise_for_failure()
    end(made[0])


def test_a_generator_that_raises_midway_delivers_nothing() -> None:
    class Broken(QuietBackend):
        def step(self, t: float, velocity: Velocity) -> Iterable[Reading]:
            yield from super().step(t, velocity)
            if t > 0.5:
                raise ValueError("midway")

    register("midway", Broken)
    result, _ = run(fault_while_driving("midway"))
    assert result.reason == Reason.fault
    assert "step() raised ValueError: midway" in result.detail


def test_after_a_fault_connecting_again_is_a_new_attempt() -> None:
    class Flaky(QuietBackend):
        healthy = True

        def readings(self, t: float, velocity: Velocity) -> list[Reading]:
            if not self.healthy:
                raise RuntimeError("brown-out")
            return super().readings(t, velocity)

    made = register("flaky", Flaky)

    async def program() -> None:
        async with Robot(backend="flaky") as robot:
            made[0].healthy = False
            assert (await robot.move_forward(1.0)).reason == Reason.fault
            made[0].healthy = True
            await robot.connect()
            assert (await robot.move_forward(0.5)).reason == Reason.reached

    run(program())


@pytest.mark.parametrize("method", ["connect", "disconnect"])
def test_what_raises_while_connecting_and_disconnecting(method: str) -> None:
    def fail(_: Backend) -> None:
        raise OSError("no such device")

    register("unreachable", type("Unreachable", (QuietBackend,), {method: fail}))

    async def program() -> None:
        robot = Robot(backend="unreachable")
        with pytest.raises(ConnectionError, match=rf"{method}\(\) raised OSError: no such device"):
            async with robot:
                pass
        assert not robot.connected

    run(program())


@pytest.mark.parametrize("make", [Robot, lambda backend: threewe.World(backend, robots=["3we_standard_v2"])])
def test_connecting_that_is_cancelled_leaves_nothing_connected(make: Any) -> None:
    made = register("quiet", QuietBackend)

    async def program() -> None:
        robot = make(backend="quiet")
        connecting = asyncio.create_task(robot.connect())
        await asyncio.sleep(0)
        connecting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await connecting
        assert made[0].disconnected == 1

    run(program())


def test_a_step_that_hangs_ends_the_motion_and_nothing_else_hangs() -> None:
    released = threading.Event()

    class Hanging(QuietBackend):
        def readings(self, t: float, velocity: Velocity) -> list[Reading]:
            if t > 0.5:
                released.wait()
            return super().readings(t, velocity)

    made = register("hanging", Hanging)
    result, error = run(fault_while_driving("hanging"))
    assert result.reason == Reason.fault
    assert "step() has not returned within 2 s" in result.detail
    assert "step() has not returned within 2 s" in error
    assert made[0].disconnected == 0
    released.set()
    end(made[0])


def test_a_step_that_never_lets_go_of_the_gil_is_waited_for() -> None:
    class Busy(QuietBackend):
        def step(self, t: float, velocity: Velocity) -> Iterable[Reading]:
            for _ in range(10_000):  # pure Python: shares the GIL by turns
                pass
            return super().step(t, velocity)

    register("busy", Busy)

    async def program() -> None:
        async with Robot(backend="busy") as robot:
            assert (await robot.move_forward(0.3)).reason == Reason.reached

    run(program())


class RealtimeBackend(QuietBackend):
    """Time is the wall clock."""

    lockstep = False


@pytest.mark.flaky(reruns=1)  # where other programs keep it from its ticks, it stops
def test_a_realtime_backend_drives_by_the_wall_clock() -> None:
    made = register("realtime", RealtimeBackend)

    async def program() -> None:
        async with Robot(backend="realtime") as robot:
            begin = time.monotonic()
            result = await robot.move_forward(0.2)
            assert result.reason == Reason.reached
            assert time.monotonic() - begin > 0.2

    run(program())
    assert made[0].disconnected == 1


@pytest.mark.parametrize("backend", [QuietBackend, RealtimeBackend])
@pytest.mark.parametrize("make", [Robot, lambda backend: threewe.World(backend, robots=["3we_standard_v2"])])
def test_a_robot_that_nobody_disconnects_is_stopped_when_it_is_dropped(make: Any, backend: type[Backend]) -> None:
    made = register("forgotten", backend)

    async def program() -> None:
        robot = make(backend="forgotten")
        await robot.connect()
        await robot.sleep(0.1)
        with pytest.warns(ResourceWarning, match="async with"):
            del robot
        await asyncio.to_thread(made[0].gone.wait)
        assert made[0].disconnected == 1
        gone = weakref.ref(made.pop())
        while gone() is not None:  # its thread ends because the world is gone
            await asyncio.sleep(0.001)

    run(program())


def test_a_realtime_backend_that_blocks_while_driving_is_a_fault() -> None:
    released = threading.Event()

    class Blocking(RealtimeBackend):
        def step(self, t: float, velocity: Velocity) -> Iterable[Reading]:
            readings = super().step(t, velocity)
            if self.pose.x > 0.05:
                released.wait()
            return readings

    made = register("blocking", Blocking)
    result, _ = run(fault_while_driving("blocking"))
    assert result.reason == Reason.fault
    assert "step() blocks beyond the end of its command" in result.detail
    released.set()
    end(made[0])


def test_a_command_expires_though_the_program_is_stuck() -> None:
    made = register("realtime", RealtimeBackend)

    async def program() -> None:
        async with Robot(backend="realtime") as robot:
            robot.set_velocity(0.2, 0.0, 0.0, hold=10.0)
            await robot.sleep(0.3)
            assert made[0].velocities[-1].vx > 0.0
            while made[0].velocities[-1] != Velocity():
                pass  # the event loop is stuck here, and so nobody renews the command

    run(program())


@pytest.mark.parametrize(
    ("backend", "message"),
    [
        (lambda _: object(), "its factory made a object, not a threewe.backend.Backend"),
        (type("Bad", (QuietBackend,), {"features": {"lidar": 10}}), "features must be threewe.Features, got dict"),
        (
            type("Bad", (QuietBackend,), {"features": Features([], Kinematics.holonomic, can_reset=True)}),
            r"its features promise reset\(\), which it does not define",
        ),
        (
            type("Bad", (QuietBackend,), {"features": Features(
                [], Kinematics.holonomic, lockstep=True, can_save=True)}),
            r"its features promise save\(\), which it does not define",
        ),
        (
            type("Bad", (QuietBackend,), {"features": Features([], Kinematics.differential)}),
            "features and profile differ in their kinematics",
        ),
        (
            type("Bad", (QuietBackend,), {"features": Features(
                [SensorInfo("a", SensorType.imu, 1.0)] * 2, Kinematics.holonomic)}),
            "two sensors are named 'a'",
        ),
        (
            type("Bad", (QuietBackend,), {"features": Features(
                [SensorInfo("a", SensorType.imu, -1.0)], Kinematics.holonomic)}),
            "sensor 'a': rate is -1 Hz; it must be positive",
        ),
    ],
)  # fmt: skip
def test_a_backend_that_cannot_be_is_refused_before_connecting(backend: Any, message: str) -> None:
    threewe.register_backend("bad", backend)
    with pytest.raises(ContractError, match=message):
        Robot(backend="bad")


def test_what_a_constructor_raises_comes_through_as_it_is() -> None:
    def factory(_: BackendOptions) -> Backend:
        raise FileNotFoundError("/dev/ttyUSB7")

    threewe.register_backend("missing", factory)
    with pytest.raises(FileNotFoundError, match="ttyUSB7"):
        Robot(backend="missing")


def test_options_arrive() -> None:
    made = register("quiet", QuietBackend)
    Robot(backend="quiet", scene="corridor_v1", noise="ideal", seed=7, start_pose=(1.0, 2.0, 0.0))
    options = made[0].options
    assert (options.scene, options.noise, options.seed) == ("corridor_v1", "ideal", 7)
    assert options.hardware == "3we_standard_v2"
    assert options.start_pose == threewe.Pose2D(1.0, 2.0, 0.0)


def test_a_backend_that_cannot_randomize_is_refused_by_name() -> None:
    register("quiet", QuietBackend)
    with pytest.raises(ConfigError, match="randomization is 'hard', but backend 'quiet' does not say that it can"):
        Robot(backend="quiet", randomization="hard")


def test_a_backend_that_can_randomize_is_given_what_to_draw_from() -> None:
    made = register("varied", type("Varied", (QuietBackend,), {"can_randomize": True}))
    Robot(backend="varied", randomization="hard")
    Robot(backend="varied")
    varied, plain = made
    assert (varied.options.randomization, plain.options.randomization) == ("hard", "none")
    drawn = varied.draw_variation(7)
    assert drawn == varied.draw_variation(7) != varied.draw_variation(8)
    assert drawn["mass"] != 1.0
    assert plain.draw_variation(7)["mass"] == 1.0
    assert set(drawn) == set(threewe._core.knob_names())


def test_the_papers_name_of_the_base_class_is_the_same_class() -> None:
    assert threewe.backend.BackendBase is Backend


def test_a_backend_has_one_robot() -> None:
    register("quiet", QuietBackend)
    with pytest.raises(ConfigError, match="backend 'quiet' has one robot, not 2"):
        threewe.World(backend="quiet")


@pytest.fixture
def installed_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package that offers two backends by entry points, of which one cannot be imported."""
    (tmp_path / "stranger.py").write_text(
        "import sys\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from toy_backend import QuietBackend as StrangersBackend\n"
    )
    metadata = tmp_path / "stranger-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: stranger\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(
        "[threewe.backends]\nstrange = stranger:StrangersBackend\nbroken_import = stranger:Missing\n"
    )
    monkeypatch.syspath_prepend(tmp_path)


@pytest.mark.usefixtures("installed_package")
def test_backends_of_installed_packages_are_found() -> None:
    with pytest.raises(ConfigError, match="unknown backend 'strang'; did you mean 'strange'"):
        Robot(backend="strang")
    assert {"mock", "strange", "broken_import"} <= set(threewe.backend_names())
    assert Robot(backend="strange").features.lockstep
    with pytest.raises(ConfigError, match="backend 'broken_import' of stranger cannot be imported"):
        Robot(backend="broken_import")


@pytest.mark.parametrize("stage", ["made", "connected", "hanging"])
def test_python_ends_though_a_backend_runs(stage: str) -> None:
    """A robot that is never disconnected is told to, and a backend that hangs does not keep Python from ending."""
    program = f"""
import asyncio, sys, time
sys.path.insert(0, {str(Path(__file__).parent)!r})
import threewe
from toy_backend import QuietBackend

class Noisy(QuietBackend):
    lockstep = False
    def disconnect(self):
        print("disconnected", flush=True)
    def step(self, t, velocity):
        if {stage == "hanging"} and t > 0.3:
            print("hangs", flush=True)
            time.sleep(1000)
        return super().step(t, velocity)

threewe.register_backend("noisy", Noisy)
robot = threewe.Robot(backend="noisy")
async def main():
    await robot.connect()
    await robot.sleep(0.5)
if {stage != "made"}:
    asyncio.run(main())
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout == {"made": "", "connected": "disconnected\n", "hanging": "hangs\n"}[stage]


def test_readings_have_their_sensors_names() -> None:
    assert OdometryReading(measured=0.0, pose=(0, 0, 0), velocity=(0, 0, 0)).sensor == "odometry"
    assert UltrasonicReading(sensor="ultrasonic_left", measured=0.0, range=1.0).type == SensorType.ultrasonic
    assert LidarReading(measured=0.0, ranges=np.zeros(3, np.float32)).type == SensorType.lidar


def test_an_observation_holds_what_the_backend_delivers() -> None:
    register("quiet", QuietBackend)

    async def observe() -> set[str]:
        async with Robot(backend="quiet") as robot:
            assert robot.profile.camera is not None  # which the backend has not
            return set(robot.get_observation())

    assert run(observe()) >= {"pose", "velocity"}
