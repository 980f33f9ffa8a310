"""The backend `real`: a robot on ROS 2, played by a process on another DDS whose body is the embedded simulator.

All of it is in real time: what is compared are places and outcomes, not durations.
"""

import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import threewe
import threewe.sync
from real_robot import FIRST_DOMAIN, PROGRAM, SILENT_DOMAIN, RealRobot
from ros2_recording import record
from threewe import ConfigError, ConnectionError, Robot, _core
from threewe.testing import check_backend, check_names

pytestmark = [
    pytest.mark.skipif(not PROGRAM.exists(), reason="the stand-in needs libfastrtps-dev and fastddsgen"),
    pytest.mark.flaky(reruns=1),  # in real time: a loaded machine may be late once, what is wrong fails each time
]

ROOT = Path(__file__).resolve().parents[2]
TRAFFIC = PROGRAM.with_name("ros2_traffic")
SMALL_BUFFER = (
    "<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast></General><Discovery>"
    "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
    '<Peers><Peer address="localhost"/></Peers></Discovery>'
    '<Internal><SocketReceiveBufferSize max="208kB"/></Internal></Domain></CycloneDDS>'
)

# Some of what the contract wants: the first by day, the others by night; all of it is in `./dev verify ros2`.
BY_DAY = [
    "every_sensor_delivers",
    "odometry_turns_left",
    "an_expired_command_stops_the_robot",
    "a_refused_command_changes_nothing",
]
BY_NIGHT = [
    "features_match_the_profile",
    "poll_before_connecting_is_refused",
    "connecting_again_works",
    "samples_arrive_in_order",
    "measured_before_received",
    "sequence_counts_from_zero",
    "scan_ranges_are_valid",
    "scan_times_fit_the_turn",
    "scan_turns_as_the_device_does",
    "odometry_starts_at_the_origin",
    "lidar_sees_the_robot_drive_forward",
    "reset_without_the_claim_is_refused",
]


@pytest.fixture(autouse=True)
def network(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(FIRST_DOMAIN))
    for name in ("ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY"):
        monkeypatch.delenv(name, raising=False)
    return monkeypatch


@pytest.fixture(scope="module")
def played() -> Iterator[RealRobot]:
    with RealRobot(FIRST_DOMAIN) as robot:
        yield robot


@pytest.mark.usefixtures("played")
async def test_a_robot_on_ros_2_drives_as_any_other() -> None:
    async with Robot(backend="real") as robot:
        assert robot.simulation is None
        assert robot.get_lidar_scan().ranges.shape == (360,)
        assert robot.get_battery_state().charge > 0.5
        result = await robot.move_to(x=2.0, y=1.0)
    result.raise_for_failure()
    assert abs(result.pose.x - 2.0) < 0.4
    assert abs(result.pose.y - 1.0) < 0.4


@pytest.mark.usefixtures("played")
@pytest.mark.parametrize("check", [*BY_DAY, *(pytest.param(name, marks=pytest.mark.nightly) for name in BY_NIGHT)])
def test_it_keeps_the_contract(check: str) -> None:
    assert check in check_names()
    check_backend("real", checks=[check], show=False, raise_failures=True)


@pytest.mark.parametrize("hardware", ["3we_standard_v2", pytest.param("turtlebot4", marks=pytest.mark.nightly)])
def test_a_robot_stands_when_its_driver_is_killed(network: pytest.MonkeyPatch, hardware: str) -> None:
    """Also one that judges commands by their stamps, with a clock that was never set."""
    network.setenv("ROS_DOMAIN_ID", str(FIRST_DOMAIN + 1))
    program = f"""
        import asyncio
        from threewe import Robot

        async def drive():
            async with Robot("real", "{hardware}") as robot:
                robot.set_velocity(0.3, 0.0, 0.0, hold=60.0)
                await robot.sleep(0.5)
                print("driving", flush=True)
                await robot.sleep(60.0)

        asyncio.run(drive())
    """
    with RealRobot(FIRST_DOMAIN + 1, "--profile", hardware, "--linked") as other:
        command = [sys.executable, "-c", textwrap.dedent(program)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as driver:
            assert driver.stdout is not None
            assert driver.stdout.readline() == "driving\n"
            driver.send_signal(signal.SIGKILL)
        # looks for as long as a robot needs to stop
        _core.ros2_discover(1.0)
    assert other.truth["commands"] > 10
    assert other.truth["speed"] < 0.02


def test_ranges_and_pictures_come_too(network: pytest.MonkeyPatch, tmp_path: Path) -> None:
    network.setenv("ROS_DOMAIN_ID", str(FIRST_DOMAIN + 2))
    profile = tmp_path / "with_camera.yaml"
    yaml = threewe.RobotProfile.load("3we_standard_v2").yaml
    camera = "    camera: {topic: /camera/image_raw, type: sensor_msgs/msg/Image}\n"
    profile.write_text(yaml.replace("  command: {topic", camera + "  command: {topic"))
    with RealRobot(FIRST_DOMAIN + 2, "--jazzy", "--camera"), threewe.sync.Robot(backend="mock") as simulated:
        expected = simulated.get_camera_image()
        with threewe.sync.Robot(backend="real", hardware=str(profile)) as robot:
            image = robot.get_camera_image()
            assert image.shape == expected.shape
            # another moment's noise, of the same place, while wrong channels are off by their colours too
            off = np.abs(image.astype(float) - expected).mean()
            assert off < 6.0
            assert np.abs(image[..., ::-1].astype(float) - expected).mean() > 1.5 * off


@pytest.mark.nightly
def test_transforms_jpegs_and_stamped_commands_do_too(network: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """As a TurtleBot 4: odometry in /tf alone, compressed pictures, TwistStamped."""
    network.setenv("ROS_DOMAIN_ID", str(FIRST_DOMAIN + 2))
    profile = tmp_path / "turtlebot4.yaml"
    yaml = threewe.RobotProfile.load("3we_standard_v2").yaml
    camera = "    camera: {topic: /camera/image_raw/compressed, type: sensor_msgs/msg/CompressedImage}\n"
    for old, new in (
        (
            "odometry: {topic: /odom, type: nav_msgs/msg/Odometry}",
            "odometry: {topic: /tf, type: tf2_msgs/msg/TFMessage}",
        ),
        ("geometry_msgs/msg/Twist}", "geometry_msgs/msg/TwistStamped}"),
        ("  command: {topic", camera + "  command: {topic"),
    ):
        assert old in yaml
        yaml = yaml.replace(old, new)
    profile.write_text(yaml)
    with threewe.sync.Robot(backend="mock") as simulated:
        expected = simulated.get_camera_image()
    turtlebot = RealRobot(FIRST_DOMAIN + 2, "--turtlebot4")
    with turtlebot as other, threewe.sync.Robot(backend="real", hardware=str(profile)) as robot:
        image = robot.get_camera_image()
        assert np.abs(image.astype(float) - expected).mean() < 8.0
        result = robot.move_to(1.0, 0.4)
        assert result.success, result
        odometry = robot.get_odometry().pose
        other.process.terminate()  # before it is put back
        other.process.wait(30)
    assert abs(odometry.x - other.truth["pose"][0]) < 0.1
    assert abs(odometry.y - other.truth["pose"][1]) < 0.1
    assert math.hypot(other.truth["pose"][0] - 1.0, other.truth["pose"][1] - 0.4) < 0.3


@pytest.mark.usefixtures("played")
def test_the_graph_shows_the_robot_and_us() -> None:
    with threewe.sync.Robot(backend="real"):
        found = _core.ros2_discover(2.0).endpoints
    scan = next(endpoint for endpoint in found if endpoint.topic == "/scan" and endpoint.publishes)
    assert scan.type == "sensor_msgs/msg/LaserScan"
    assert not scan.reliable
    assert not scan.hash  # as micro-ROS
    ours = next(endpoint for endpoint in found if endpoint.topic == "/cmd_vel" and endpoint.publishes)
    assert ours.node == "/threewe"
    assert _core.ros2_distributions_with(ours.type, ours.hash) == ["humble", "jazzy", "kilted"]


def sleep_until(robot: threewe.sync.Robot, condition: Callable[[], bool]) -> None:
    """For as long as discovery and a computer that has other things to do may take."""
    for _ in range(200):
        if condition():
            return
        robot.sleep(0.1)
    pytest.fail("it has not come true within 20 s")


@pytest.mark.nightly
def test_a_robot_that_is_started_again_goes_on(network: pytest.MonkeyPatch) -> None:
    """As an agent's restart: new endpoints of the same names, and odometry that begins elsewhere."""
    network.setenv("ROS_DOMAIN_ID", str(FIRST_DOMAIN + 1))
    with RealRobot(FIRST_DOMAIN + 1) as first:
        robot = threewe.sync.Robot(backend="real")
        robot.connect()
        driven = robot.move_forward(0.4)
        before = robot.get_odometry().pose
    assert driven.success
    assert first.truth["speed"] < 0.02
    sleep_until(robot, lambda: not robot.health["odometry"].ok)
    with RealRobot(FIRST_DOMAIN + 1):
        sleep_until(robot, lambda: all(sensor.ok for sensor in robot.health.values()))
        after = robot.get_odometry().pose
        assert abs(after.x - before.x) < 0.05
        assert abs(after.theta - before.theta) < 0.05
        assert robot.rotate(0.5).success
        robot.disconnect()


@pytest.mark.nightly
def test_others_are_told_of_us_in_their_layout(network: pytest.MonkeyPatch) -> None:
    """The stand-in's graph is that of Humble, as micro-ROS agents have it; it knows us by name, with our endpoints."""
    network.setenv("ROS_DOMAIN_ID", str(FIRST_DOMAIN + 2))
    with RealRobot(FIRST_DOMAIN + 2) as other, threewe.sync.Robot(backend="real") as robot:
        robot.sleep(1.5)
    topics = 8  # of sensors
    assert other.truth["nodes"] == {"/threewe": topics + 3}  # with commands, diagnostics and static transforms


def discover(*options: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", "from threewe.cli import main; main()", "ros2", "discover", *options]
    return subprocess.run(command, capture_output=True, text=True, env=os.environ | {"COLUMNS": "250"})


@pytest.mark.nightly
def test_what_the_command_line_finds_is_written_as_a_link_that_drives(
    network: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Of a robot whose topics are not those of its profile."""
    domain = FIRST_DOMAIN + 1
    network.setenv("ROS_DOMAIN_ID", str(domain))
    profile = profile_with(tmp_path, ("topic: /scan,", "topic: /laser,"))
    written = tmp_path / "written.yaml"
    with RealRobot(domain, "--camera"):
        done = discover("--robot", profile, "--write", str(written))
        assert done.returncode == 0, done.stderr
        row = next(line for line in done.stdout.splitlines() if "/scan" in line)
        assert "humble or" in row
        assert "best effort" in row
        assert "lidar" in row
        rate = re.search(r" (\d+\.\d) ", row)
        assert rate
        assert 5.0 < float(rate.group(1)) < 12.0
        assert "none: no sensor comes as this type" not in row
        with threewe.sync.Robot(backend="real", hardware=str(written)) as robot:
            assert "camera" in robot.health
            assert robot.rotate(0.3).success


def test_the_command_line_says_where_it_looked(network: pytest.MonkeyPatch) -> None:
    network.setenv("ROS_DOMAIN_ID", str(SILENT_DOMAIN))
    done = discover("--seconds", "1")
    assert done.returncode == 1
    assert f"no ROS 2 node was found in domain {SILENT_DOMAIN} on this computer within 1 s (interfaces: " in done.stdout


def profile_with(folder: Path, *changes: tuple[str, str]) -> str:
    """The standard robot's, with changes to its link."""
    yaml = threewe.RobotProfile.load("3we_standard_v2").yaml
    for old, new in changes:
        assert old in yaml
        yaml = yaml.replace(old, new)
    profile = folder / "changed.yaml"
    profile.write_text(yaml)
    return str(profile)


@pytest.mark.usefixtures("played")
def test_a_topic_that_is_not_there_is_named(tmp_path: Path) -> None:
    profile = profile_with(tmp_path, ("topic: /scan,", "topic: /laser,"), ("topic: /imu,", "topic: /odom,"))
    with pytest.raises(ConnectionError) as raised, threewe.sync.Robot(backend="real", hardware=profile):
        pass
    text = str(raised.value)
    assert "lidar: no node publishes /laser (sensor_msgs/msg/LaserScan); of that type there is /scan" in text
    assert "imu: /odom is of type nav_msgs/msg/Odometry, the profile has sensor_msgs/msg/Imu" in text


@pytest.mark.nightly
@pytest.mark.usefixtures("played")
def test_velocities_are_of_the_type_that_the_robot_takes(tmp_path: Path) -> None:
    profile = profile_with(tmp_path, ("geometry_msgs/msg/Twist}", "geometry_msgs/msg/TwistStamped}"))
    with threewe.sync.Robot(backend="real", hardware=profile) as robot:
        assert robot.rotate(0.5).success


def test_a_robot_that_is_driven_already_is_refused(network: pytest.MonkeyPatch, tmp_path: Path) -> None:
    domain = FIRST_DOMAIN + 1
    network.setenv("ROS_DOMAIN_ID", str(domain))
    with RealRobot(domain), threewe.sync.Robot(backend="real") as first:
        driven = "command: /cmd_vel is published by /threewe as well"
        with pytest.raises(ConnectionError, match=driven), threewe.sync.Robot(backend="real"):
            pass
        assert first.rotate(0.3).success
        shared = profile_with(tmp_path, ("msg/Twist}", "msg/Twist, shared: true}"))
        with threewe.sync.Robot(backend="real", hardware=shared) as second:
            assert second.health["lidar"].ok


@pytest.mark.nightly
def test_another_driver_that_comes_later_is_named(
    network: pytest.MonkeyPatch, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    domain = FIRST_DOMAIN + 1
    network.setenv("ROS_DOMAIN_ID", str(domain))
    shared = profile_with(tmp_path, ("msg/Twist}", "msg/Twist, shared: true}"))
    with (
        RealRobot(domain),
        threewe.sync.Robot(backend="real") as first,
        threewe.sync.Robot(backend="real", hardware=shared),
    ):
        sleep_until(first, lambda: "command: /cmd_vel is published by /threewe as well" in caplog.text)


@pytest.mark.nightly
def test_two_robots_on_the_same_topics_are_not_mixed(
    network: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    domain = FIRST_DOMAIN + 1
    network.setenv("ROS_DOMAIN_ID", str(domain))
    rivals = "odometry: two nodes publish it on /odom"
    with RealRobot(domain):
        with threewe.sync.Robot(backend="real") as robot, RealRobot(domain, "--seed", "1"):
            sleep_until(robot, lambda: rivals in caplog.text)
            start = robot.get_odometry().pose
            robot.set_velocity(0.2, 0.0, 0.0, hold=10.0)
            robot.sleep(3.0)
            robot.stop()
            robot.sleep(0.5)
            end = robot.get_odometry().pose
            assert math.hypot(end.x - start.x, end.y - start.y) > 0.45
        with (
            RealRobot(domain, "--seed", "1"),
            pytest.raises(ConnectionError, match=rivals),
            threewe.sync.Robot(backend="real"),
        ):
            pass


@pytest.mark.nightly
def test_diagnostics_say_how_each_topic_is(network: pytest.MonkeyPatch, tmp_path: Path) -> None:
    domain = FIRST_DOMAIN + 1
    network.setenv("ROS_DOMAIN_ID", str(domain))
    types = {"/diagnostics": "diagnostic_msgs/msg/DiagnosticArray"}
    robot = threewe.sync.Robot(backend="real")
    with RealRobot(domain):
        robot.connect()
        robot.sleep(1.0)
        fine = record(domain, tmp_path / "fine", types, "0 0 0 125\n", "")["/diagnostics"]
    gone = record(domain, tmp_path / "gone", types, "0 0 0 250\n", "")["/diagnostics"]
    robot.disconnect()
    assert len(fine) >= 2
    said = {status.name: status for status in fine[-1].status}
    assert said["threewe: lidar"].hardware_id == "3we_standard_v2"
    assert {status.message for status in said.values()} == {"ok"}
    assert set(said) >= {"threewe: command", "threewe: odometry", "threewe: ultrasonic_left"}
    said = {status.name: status for status in gone[-1].status}
    assert said["threewe: lidar"].level == 2
    assert said["threewe: lidar"].message == "lidar: no node publishes /scan (sensor_msgs/msg/LaserScan)"


@pytest.mark.nightly
def test_frames_without_a_transform_are_named(network: pytest.MonkeyPatch, tmp_path: Path) -> None:
    domain = FIRST_DOMAIN + 1
    network.setenv("ROS_DOMAIN_ID", str(domain))
    profile = profile_with(
        tmp_path,
        (
            "odometry: {topic: /odom, type: nav_msgs/msg/Odometry}",
            "odometry: {topic: /tf, type: tf2_msgs/msg/TFMessage}",
        ),
        ("  stops: {", "  frames: {odom: odom, base: base_footprint}\n  stops: {"),
    )
    named = "odometry: /tf has no transform odom -> base_footprint; there is base_link -> left_wheel, odom -> base_link"
    with RealRobot(domain, "--turtlebot4"), pytest.raises(ConnectionError, match=named):
        threewe.sync.Robot(backend="real", hardware=profile).connect()


def test_types_of_another_make_are_named(network: pytest.MonkeyPatch) -> None:
    domain = FIRST_DOMAIN + 1
    network.setenv("ROS_DOMAIN_ID", str(domain))
    wrong = "RIHS01_" + 64 * "0"
    named = f"odometry: /odom is of a nav_msgs/msg/Odometry that no distribution has which we know \\({wrong}"
    with RealRobot(domain, "--hash", wrong), pytest.raises(ConnectionError, match=named):
        threewe.sync.Robot(backend="real").connect()


@pytest.mark.nightly
def test_a_topic_that_changes_its_type_is_named(network: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    domain = FIRST_DOMAIN + 1
    network.setenv("ROS_DOMAIN_ID", str(domain))
    with RealRobot(domain):
        robot = threewe.sync.Robot(backend="real")
        robot.connect()
    with RealRobot(domain, "--turtlebot4"):
        sleep_until(robot, lambda: "odometry: no node publishes /odom (nav_msgs/msg/Odometry)" in caplog.text)
        takes = "command: /cmd_vel is of type geometry_msgs/msg/TwistStamped, the profile has geometry_msgs/msg/Twist"
        sleep_until(robot, lambda: takes in caplog.text)
        robot.disconnect()


@pytest.mark.nightly
def test_silence_says_what_was_seen_and_what_to_try(network: pytest.MonkeyPatch) -> None:
    network.setenv("ROS_DOMAIN_ID", str(SILENT_DOMAIN))
    nothing = rf"no ROS 2 node was found in domain {SILENT_DOMAIN} on this computer within 10 s \(.*127.0.0.1"
    with pytest.raises(ConnectionError, match=nothing), threewe.sync.Robot(backend="real"):
        pass


def test_a_network_that_is_not_there_is_named(network: pytest.MonkeyPatch) -> None:
    """Of the configuration of Cyclone DDS, and in a network namespace in which nothing is up."""
    network.setenv("ROS_DOMAIN_ID", str(SILENT_DOMAIN))
    program = "import threewe.sync; threewe.sync.Robot('real').connect()"
    interface = '<Interfaces><NetworkInterface name="eth77"/></Interfaces>'
    interface = f"<CycloneDDS><Domain><General>{interface}</General></Domain></CycloneDDS>"
    asked = os.environ | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT", "CYCLONEDDS_URI": interface}
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=asked)
    assert f"Cyclone DDS cannot begin in ROS domain {SILENT_DOMAIN} (interfaces: " in run.stderr
    assert "eth77: does not match an available interface" in run.stderr

    unshare = shutil.which("unshare")
    assert unshare
    run = subprocess.run([unshare, "-rn", sys.executable, "-c", program], capture_output=True, text=True)
    if "unshare:" in run.stderr:
        pytest.skip("this computer lets no one make network namespaces")
    assert f"Cyclone DDS cannot begin in ROS domain {SILENT_DOMAIN} (no network interface is up)" in run.stderr


def test_without_the_library_one_error_names_the_package() -> None:
    """In a mount namespace of its own, where the library is an empty file."""
    found = subprocess.run(["ldconfig", "-p"], capture_output=True, text=True).stdout
    library = next(line.split()[-1] for line in found.splitlines() if "libddsc.so.0debian" in line)
    program = "import threewe; print(threewe.backend_names()); threewe.Robot(backend='real')"
    hidden = f'mount --bind /dev/null {Path(library).resolve()} && exec {sys.executable} -c "{program}"'
    unshare = shutil.which("unshare")
    assert unshare
    run = subprocess.run([unshare, "-rm", "sh", "-c", hidden], capture_output=True, text=True)
    if "unshare:" in run.stderr or "mount:" in run.stderr:
        pytest.skip("this computer lets nobody mount")
    assert "'real'" in run.stdout
    assert "backend 'real' needs Cyclone DDS 0.10.2: " in run.stderr
    assert "apt install cyclonedds-dev" in run.stderr


@pytest.mark.parametrize(
    "hardware",
    ["turtlebot4", *(pytest.param(name, marks=pytest.mark.nightly) for name in ("turtlebot3_burger", "nav2_robot"))],
)
def test_robots_of_others_are_ready_to_be_driven(network: pytest.MonkeyPatch, hardware: str) -> None:
    """By names, types and frames of their links, over a process that has them."""
    domain = FIRST_DOMAIN + 2
    network.setenv("ROS_DOMAIN_ID", str(domain))
    with (
        RealRobot(domain, "--profile", hardware, "--linked") as played,
        threewe.sync.Robot("real", hardware) as robot,
    ):
        if hardware == "turtlebot4":
            assert robot.get_image().shape == (250, 250, 3)
        result = robot.move_to(0.4, 0.0)
        assert result.success, result
        played.process.terminate()
        played.process.wait(30)
    assert math.dist(played.truth["pose"][:2], (0.4, 0.0)) < 0.25


def test_what_only_simulators_can_is_refused() -> None:
    with pytest.raises(ConfigError, match="has no link"):
        Robot(backend="real", hardware="turtlebot_like")
    with pytest.raises(ConfigError, match="start pose"):
        Robot(backend="real", start_pose=threewe.Pose2D(1, 1, 0))
    with pytest.raises(ConfigError, match="randomization"):
        Robot(backend="real", randomization="sim2real_v1")


def test_a_wrong_network_is_a_wrong_variable(network: pytest.MonkeyPatch) -> None:
    network.setenv("ROS_DOMAIN_ID", "many")
    with pytest.raises(ConfigError, match="ROS_DOMAIN_ID is 'many'"):
        Robot(backend="real")


@pytest.mark.nightly
@pytest.mark.parametrize("small", [False, True])
def test_colours_and_depths_come_together_or_their_loss_is_named(tmp_path: Path, small: bool) -> None:
    domain = str(FIRST_DOMAIN + 2)
    text = (ROOT / "assets/robots/3we_depth_v2.yaml").read_text()
    profile = tmp_path / "robot.yaml"
    profile.write_text(
        text
        + """
link:
  driver: ros2
  topics:
    odometry: {topic: /odom, type: nav_msgs/msg/Odometry}
    camera: {topic: /camera/image_raw, type: sensor_msgs/msg/Image}
    depth: {topic: /camera/depth, type: sensor_msgs/msg/Image}
  command: {topic: /cmd_vel, type: geometry_msgs/msg/Twist}
  stops: {by: the stand-in, after: 0.2}
"""
    )
    environment = os.environ | {"ROS_DOMAIN_ID": domain}
    if small:
        environment |= {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT", "CYCLONEDDS_URI": SMALL_BUFFER}
    streams = [PROGRAM.with_name("ros2_streams"), domain, "--images"]
    with subprocess.Popen(streams, stdout=subprocess.PIPE, text=True) as sender:
        assert sender.stdout is not None
        assert sender.stdout.readline() == "ready\n"
        got = subprocess.run([TRAFFIC, profile, "4"], capture_output=True, text=True, env=environment, timeout=60)
        sender.terminate()
    if got.returncode != 0:  # all of them were lost
        assert "images are lost: " in got.stderr
        return
    received = json.loads(got.stdout)
    assert received["images"]
    frames = 1 + (received["images"][-1][0] - received["images"][0][0]) % 1024
    lost = frames - len(received["images"])
    assert lost < 6 or "are lost: " in received["fault"]
