"""The backend `gazebo`: a process on Gazebo's own transport stands in for it, with an exported world.

What it has of Gazebo's ways is stated in tests/gazebo/simulator.cpp. Gazebo itself is not in Debian: it was not run.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import threewe
import threewe.sync
from gazebo_world import PARTITION, PROGRAM, GazeboWorld
from threewe import ConfigError, ConnectionError, Pose2D, Robot, World
from threewe.testing import check_backend, check_names
from typer.testing import CliRunner

pytestmark = pytest.mark.skipif(
    not PROGRAM.exists(), reason="the stand-in needs libignition-transport-dev, libsdformat-dev, protobuf-compiler"
)

# Some of what the contract wants: the first by day, the others by night; all of it is in `./dev verify ros2`.
BY_DAY = [
    "advance_is_exact",
    "every_sensor_delivers",
    "scan_turns_as_the_device_does",
    "reset_begins_anew",
]
BY_NIGHT = [
    "features_match_the_profile",
    "connecting_again_works",
    "time_starts_at_zero",
    "samples_arrive_in_order",
    "rates_are_as_listed",
    "lidar_sees_the_robot_turn_left",
    "one_ultrasonic_pings_at_a_time",
    "images_are_blue_green_red",
    "sideways_is_left",
    "an_expired_command_stops_the_robot",
    "reset_forgets_the_command",
    "truth_begins_at_the_start_pose",
    "reset_puts_the_robot_at_its_pose",
]


@pytest.fixture(autouse=True)
def partition(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    monkeypatch.setenv("GZ_PARTITION", PARTITION)
    for name in ("GZ_IP", "IGN_IP", "GZ_DISCOVERY_MSG_PORT", "GZ_DISCOVERY_SRV_PORT", "GZ_DISCOVERY_MULTICAST_IP"):
        monkeypatch.delenv(name, raising=False)
    return monkeypatch


@pytest.fixture(scope="module")
def office(tmp_path_factory: pytest.TempPathFactory) -> Iterator[GazeboWorld]:
    with GazeboWorld(tmp_path_factory.mktemp("office"), partition=PARTITION) as world:
        yield world


@pytest.mark.usefixtures("office")
async def test_a_robot_in_gazebo_drives_as_any_other() -> None:
    async with Robot(backend="gazebo") as robot:
        assert robot.simulation is not None
        result = await robot.move_to(x=2.0, y=1.0)
        truth = robot.simulation.true_pose()
        assert robot.simulation.max_collision_speed() == 0.0
    result.raise_for_failure()
    assert abs(truth.x - 2.0) < 0.3
    assert abs(truth.y - 1.0) < 0.3


@pytest.mark.usefixtures("office")
@pytest.mark.parametrize("check", [*BY_DAY, *(pytest.param(name, marks=pytest.mark.nightly) for name in BY_NIGHT)])
def test_it_keeps_the_contract(check: str) -> None:
    assert check in check_names()
    (result,) = check_backend("gazebo", checks=[check], show=False, raise_failures=True)
    assert result.outcome.name == "passed"


def drive_around(robot: threewe.sync.Robot) -> list[object]:
    """What it measures on the way, and where that led."""
    seen: list[object] = []
    for velocity in ((0.3, 0.0, 0.0), (0.2, 0.1, 0.6), (0.0, 0.0, 0.0)):
        robot.set_velocity(*velocity, hold=1.0)
        for _ in range(20):
            robot.sleep(0.04)
            imu = robot.get_imu()
            seen.append((imu.angular_velocity.tolist(), imu.linear_acceleration.tolist()))
            seen.append(robot.get_lidar_scan().ranges.tobytes())
            pose = robot.get_odometry().pose
            seen.append((pose.x, pose.y, pose.theta))
    assert robot.simulation is not None
    pose = robot.simulation.true_pose()
    return [*seen, (pose.x, pose.y, pose.theta), robot.simulation.distance_driven()]


def test_a_world_that_starts_paused_is_driven_as_one_that_runs(tmp_path: Path) -> None:
    """As `gz sim -s` without -r."""
    with GazeboWorld(tmp_path, paused=True), threewe.sync.Robot(backend="gazebo") as robot:
        assert robot.move_to(0.6, 0.0).success
        assert robot.simulation is not None
        assert abs(robot.simulation.true_pose().x - 0.6) < 0.3


@pytest.mark.nightly
def test_two_simulators_are_driven_to_the_same_bits(tmp_path: Path) -> None:
    """Although messages, and what is drawn, come when they come: it waits in lockstep for what is due.

    Without noise, which Gazebo begins anew with no episode.
    """
    runs = []
    for _ in range(2):
        with GazeboWorld(tmp_path, noise=False), threewe.sync.Robot(backend="gazebo") as robot:
            runs.append(drive_around(robot))
    assert runs[0] == runs[1]


def test_depth_and_colours_are_those_of_the_scene(tmp_path: Path) -> None:
    robot_file = "3we_depth_v2"
    with threewe.sync.Robot(backend="mock", hardware=robot_file, noise="ideal") as simulated:
        expected = simulated.get_rgbd_image()
    with (
        GazeboWorld(tmp_path, robot=robot_file),
        threewe.sync.Robot(backend="gazebo", hardware=robot_file) as robot,
    ):
        image = robot.get_rgbd_image()
    assert image.color.shape == expected.color.shape
    off = np.abs(image.color.astype(float) - expected.color).mean()
    assert np.abs(image.color[..., ::-1].astype(float) - expected.color).mean() > 2 * off
    both = (image.depth > 0) & (expected.depth > 0)
    assert both.mean() > 0.3
    assert np.median(np.abs(image.depth - expected.depth)[both]) < 0.02


@pytest.mark.nightly
def test_a_differential_robot_has_the_odometry_of_its_wheels(tmp_path: Path) -> None:
    with (
        GazeboWorld(tmp_path, robot="turtlebot_like", scene="apartment_v1"),
        threewe.sync.Robot(backend="gazebo", hardware="turtlebot_like", scene="apartment_v1") as robot,
    ):
        assert robot.move_to(1.0, 0.3).success
        pose = robot.get_odometry().pose
    assert abs(pose.x - 1.0) < 0.3
    assert abs(pose.y - 0.3) < 0.3


@pytest.mark.usefixtures("office")
def test_a_collision_is_counted_with_its_speed() -> None:
    """As the embedded simulator counts it: the same blind drive, there and here."""
    done = subprocess.run([PROGRAM.with_name("gazebo_collision")], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    (speed, driven), there = ([float(number) for number in line.split()] for line in done.stdout.splitlines())
    assert speed > 0.1
    assert there[0] == pytest.approx(speed, rel=0.25)
    assert there[1] == pytest.approx(driven, rel=0.05)


@pytest.mark.usefixtures("office")
def test_a_reset_forgets_what_was_and_begins_where_it_is_told() -> None:
    with threewe.sync.Robot(backend="gazebo", start_pose=Pose2D(0.5, 0.2, 0.3)) as robot:
        assert robot.simulation is not None
        start = robot.simulation.true_pose()
        assert (start.x, start.y, start.theta) == pytest.approx((0.5, 0.2, 0.3), abs=0.01)
        robot.move_forward(0.3)
        assert robot.simulation.distance_driven() > 0.2
        robot.simulation.reset(seed=1, pose=Pose2D(0.0, 0.0, 1.0))
        there = robot.simulation.true_pose()
        assert (there.x, there.y, there.theta) == pytest.approx((0.0, 0.0, 1.0), abs=0.01)
        assert robot.simulation.distance_driven() < 0.01
        pose = robot.get_pose()
        assert (pose.x, pose.y) == pytest.approx((0.0, 0.0), abs=0.05)


# What goes wrong, each with one error that says what.


def connect_fails(**options: object) -> str:
    with pytest.raises(ConnectionError) as raised, threewe.sync.Robot(backend="gazebo", **options):  # type: ignore[arg-type]
        pass
    return str(raised.value)


def test_without_gazebo_it_says_how_to_start_it(partition: pytest.MonkeyPatch) -> None:
    partition.setenv("GZ_PARTITION", "nobody_is_here")
    partition.setenv("GZ_DISCOVERY_MSG_PORT", "20317")  # nor anything else
    partition.setenv("GZ_DISCOVERY_SRV_PORT", "20318")
    said = connect_fails()
    assert "no Gazebo was found within 6 s, in partition 'nobody_is_here'" in said
    assert "threewe gazebo launch --scene office_v2 --robot 3we_standard_v2" in said


@pytest.mark.nightly
@pytest.mark.usefixtures("office")
def test_another_partition_is_named(partition: pytest.MonkeyPatch) -> None:
    partition.setenv("GZ_PARTITION", "elsewhere")
    said = connect_fails()
    assert f"'office_v2' in partition '{PARTITION}'" in said
    assert "this process is in partition 'elsewhere': set GZ_PARTITION alike" in said


@pytest.mark.usefixtures("office")
def test_another_world_is_named() -> None:
    assert "Gazebo runs the world 'office_v2', not 'apartment_v1'" in connect_fails(scene="apartment_v1")


@pytest.mark.nightly
@pytest.mark.usefixtures("office")
def test_another_robot_is_named() -> None:
    said = connect_fails(hardware="3we_depth_v2")
    assert "camera: nothing is published on /camera/image" in said
    assert "is not as `threewe gazebo launch` and `threewe export --format sdf` make it for '3we_depth_v2'" in said


@pytest.mark.nightly
def test_topics_of_a_wrong_type_and_those_that_lack_are_named(tmp_path: Path) -> None:
    with GazeboWorld(tmp_path, "--wrong-type", "/lidar", "--mute", "/imu"):
        said = connect_fails()
    assert "lidar: /lidar carries gz.msgs.StringMsg, not gz.msgs.LaserScan" in said
    assert "imu: nothing is published on /imu" in said


@pytest.mark.nightly
def test_two_odometries_on_one_topic_are_named(tmp_path: Path) -> None:
    with GazeboWorld(tmp_path, odometries_share="odom"):
        said = connect_fails()
    assert re.search("odometry: [23] publish on /odom: each needs a topic of its own", said)


def test_a_world_of_other_beams_is_named(tmp_path: Path) -> None:
    profile = tmp_path / "3we_standard_v2.yaml"
    yaml = threewe.RobotProfile.load("3we_standard_v2").yaml
    assert "beams: 360" in yaml
    profile.write_text(yaml.replace("beams: 360", "beams: 180"))
    with GazeboWorld(tmp_path):
        said = connect_fails(hardware=str(profile))
    assert "lidar: /lidar delivers a scan of 360 beams; the profile has 180" in said


@pytest.mark.nightly
def test_a_world_that_never_steps_is_named(tmp_path: Path) -> None:
    with GazeboWorld(tmp_path, "--never-step"):
        said = connect_fails()
    assert "Gazebo does not step, though it was asked for a first step: its clock stands at " in said


@pytest.mark.nightly
def test_a_world_that_others_run_is_named(tmp_path: Path) -> None:
    with GazeboWorld(tmp_path, "--runs-by-itself"):
        assert "Gazebo does not pause" in connect_fails()


@pytest.mark.nightly
@pytest.mark.usefixtures("office")
def test_two_simulators_of_one_world_are_named(tmp_path: Path) -> None:
    with GazeboWorld(tmp_path, partition=PARTITION):
        assert "2 simulators run the world 'office_v2'" in connect_fails()


@pytest.mark.nightly
def test_a_simulator_that_dies_ends_the_motion(tmp_path: Path) -> None:
    with GazeboWorld(tmp_path) as world, threewe.sync.Robot(backend="gazebo") as robot:
        robot.move_forward(0.2)
        world.process.send_signal(signal.SIGKILL)
        result = robot.move_forward(0.5)
        assert result.reason.name == "fault"
        assert "Gazebo has gone" in result.detail


@pytest.mark.nightly
def test_a_simulator_that_is_started_again_goes_on(tmp_path: Path) -> None:
    partition = PARTITION + "_again"
    with GazeboWorld(tmp_path, partition=partition) as world:
        robot = threewe.sync.Robot(backend="gazebo")
        robot.connect()
        robot.move_forward(0.3)
        before = robot.get_odometry().pose
        world.process.send_signal(signal.SIGKILL)
        assert robot.move_forward(0.5).reason.name == "fault"
    with GazeboWorld(tmp_path, partition=partition):
        robot.connect()
        after = robot.get_odometry().pose
        assert (after.x, after.y) == pytest.approx((before.x, before.y), abs=0.05)
        assert robot.move_forward(0.2).success
        robot.disconnect()


def test_what_the_world_has_settled_is_refused() -> None:
    with pytest.raises(ConfigError, match="noise is 'ideal'"):
        Robot(backend="gazebo", noise="ideal")
    with pytest.raises(ConfigError, match="size of images"):
        Robot(backend="gazebo", image_size=(48, 64))
    with pytest.raises(ConfigError, match="randomization is 'mild'"):
        Robot(backend="gazebo", randomization="mild")
    with pytest.raises(ConfigError, match="a world of 2 robots"):
        World(backend="gazebo", robots=["3we_standard_v2", "3we_standard_v2"])


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("GZ_IP", "my_computer", "'my_computer' is no IPv4 address"),
        ("GZ_DISCOVERY_MSG_PORT", "70000", "GZ_DISCOVERY_MSG_PORT is '70000'; it must be a port from 1 to 65535"),
    ],
)
def test_a_wrong_variable_is_named(name: str, value: str, said: str, partition: pytest.MonkeyPatch) -> None:
    partition.setenv(name, value)
    with pytest.raises(ConfigError, match=said):
        Robot(backend="gazebo")


def test_without_the_library_one_error_names_the_package() -> None:
    """In a mount namespace of its own, where the library is an empty file."""
    found = subprocess.run(["ldconfig", "-p"], capture_output=True, text=True).stdout
    library = next(line.split()[-1] for line in found.splitlines() if "libzmq.so.5" in line)
    program = "import threewe; print(threewe.backend_names()); threewe.Robot(backend='gazebo')"
    hidden = f'mount --bind /dev/null {Path(library).resolve()} && exec {sys.executable} -c "{program}"'
    unshare = shutil.which("unshare")
    assert unshare
    run = subprocess.run([unshare, "-rm", "sh", "-c", hidden], capture_output=True, text=True)
    if "unshare:" in run.stderr or "mount:" in run.stderr:
        pytest.skip("this computer lets no user mount")
    assert "'gazebo'" in run.stdout
    assert "backend 'gazebo' needs ZeroMQ 4: " in run.stderr
    assert "apt install libzmq5" in run.stderr


# Messages, and the command line.


def test_messages_are_those_of_protocol_buffers() -> None:
    """Random ones, written by us and read by its own code, and the other way round."""
    seed = str(np.random.default_rng().integers(2**31))
    done = subprocess.run([PROGRAM.with_name("gazebo_exchange"), "3000", seed], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("by", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.nightly)])
def test_launch_starts_gazebo_with_the_exported_world(
    partition: pytest.MonkeyPatch, tmp_path: Path, by: signal.Signals
) -> None:
    """A `gz` that is the stand-in, and takes down how it was called."""
    gz = tmp_path / "bin" / "gz"
    gz.parent.mkdir()
    gz.write_text(
        f'#!/bin/sh\necho "$GZ_SIM_RESOURCE_PATH $@" > {tmp_path}/called\nfor world; do :; done\n'
        f'exec {PROGRAM} "$world" -r\n'
    )
    gz.chmod(0o755)
    kept = tmp_path / "kept"
    environment = os.environ | {"PATH": f"{gz.parent}:{os.environ['PATH']}", "IGN_PARTITION": PARTITION + "_launch"}
    command = [sys.executable, "-c", "from threewe.cli import main; main()", "gazebo", "launch"]
    command += ["--scene", "apartment_v1", "--folder", str(kept), "--seed", "5"]
    partition.setenv("GZ_PARTITION", PARTITION + "_launch")
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as launched:
        assert launched.stdout is not None
        assert launched.stdout.readline() == "ready\n"
        with threewe.sync.Robot(backend="gazebo", scene="apartment_v1") as robot:
            assert robot.move_forward(0.2).success
        launched.send_signal(by)
        if by == signal.SIGINT:
            subprocess.run(["pkill", "-INT", "-P", str(launched.pid)])  # as a terminal does
        assert launched.wait(30) == 0
    called = (tmp_path / "called").read_text().split()
    assert called == [
        str(kept / "models"), "sim", "-s", "-r", "--headless-rendering", "--seed", "5", str(kept / "world.sdf"),
    ]  # fmt: skip
    assert "<real_time_factor>0</real_time_factor>" in (kept / "world.sdf").read_text()


def test_launch_without_gazebo_says_how_to_install_it(partition: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from threewe.cli import app

    partition.setenv("PATH", "")
    done = CliRunner().invoke(app, ["gazebo", "launch", "--folder", str(tmp_path)])
    assert isinstance(done.exception, ConfigError)
    assert "Gazebo Harmonic is not installed: apt install gz-harmonic" in str(done.exception)
    assert (tmp_path / "world.sdf").exists()
