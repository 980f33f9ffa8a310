"""`threewe ros2 serve`: the simulator as a robot on ROS 2, read by a recorder on another DDS and driven by us."""

import io
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import threewe.sync
from PIL import Image
from real_robot import FIRST_DOMAIN, PROGRAM
from threewe import ConfigError, _core

pytest.importorskip("rosbags", reason="not shown: needs rosbags")
from ros2_recording import PROGRAMS, ROOT, Served, dds_type, record, simulate

pytestmark = [
    pytest.mark.skipif(not PROGRAM.exists(), reason="the recorder needs libfastrtps-dev and fastddsgen"),
    pytest.mark.flaky(reruns=1),  # as in test_real.py
]

SCENE, PROFILE, SEED = "office_v2", "3we_standard_v2", 7
COMMANDS = "0.2 0.1 0.3 30\n0.1 0 -0.2 25\n0 0 0 5\n"
PERIODS = 60
TYPES = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/scan": "sensor_msgs/msg/LaserScan",
    "/imu": "sensor_msgs/msg/Imu",
    "/odom": "nav_msgs/msg/Odometry",
    "/battery_state": "sensor_msgs/msg/BatteryState",
    "/ultrasonic/left": "sensor_msgs/msg/Range",
    "/camera/image_raw": "sensor_msgs/msg/Image",
    "/camera/image_raw/compressed": "sensor_msgs/msg/CompressedImage",
    "/camera/camera_info": "sensor_msgs/msg/CameraInfo",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/map": "nav_msgs/msg/OccupancyGrid",
    "/robot_description": "std_msgs/msg/String",
}
KEPT = ("/tf_static", "/map", "/robot_description")


@pytest.fixture(autouse=True)
def network(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(FIRST_DOMAIN))
    for name in ("ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY"):
        monkeypatch.delenv(name, raising=False)
    return monkeypatch


def ns(stamp: Any) -> int:
    return int(stamp.sec * 10**9 + stamp.nanosec)


def yaw(rotation: Any) -> float:
    assert rotation.x == rotation.y == 0.0
    return 2.0 * math.atan2(rotation.z, rotation.w)


def assert_same(values: list[float], *given: Any) -> None:
    """Floats of 32 bits, as most messages have them."""
    np.testing.assert_allclose(np.array(given, dtype=float), np.array(values), rtol=2e-7, atol=1e-7)


def test_a_record_on_another_dds_is_what_the_simulator_measured(tmp_path: Path) -> None:
    with Served("--scene", SCENE, "--robot", PROFILE, "--seed", str(SEED), "--lockstep", "--map"):
        file = tmp_path / "record"
        messages = record(FIRST_DOMAIN, file, TYPES, COMMANDS, "--drive /cmd_vel", kept=KEPT)
    samples = simulate(SCENE, PROFILE, SEED, COMMANDS)

    clocks = sorted({ns(message.clock) for message in messages["/clock"]})
    assert clocks == [20_000_000 * i for i in range(PERIODS + 1)]

    def pairs(topic: str, sensor: str) -> list[tuple[Any, list[float]]]:
        found = messages[topic]
        assert [ns(message.header.stamp) for message in found] == [measured for measured, _ in samples[sensor]]
        return list(zip(found, (values for _, values in samples[sensor]), strict=True))

    for scan, (first, step, time, near, far, *ranges) in pairs("/scan", "lidar"):
        assert scan.header.frame_id == "lidar"
        assert scan.angle_max == pytest.approx(first + step * (len(ranges) - 1), abs=1e-6)
        assert_same(
            [first, step, time, near, far],
            scan.angle_min,
            scan.angle_increment,
            scan.time_increment,
            scan.range_min,
            scan.range_max,
        )
        truth = np.array(ranges, dtype=np.float32)
        expected = np.where(truth == 0.0, np.nan, np.where(truth >= np.float32(far), np.inf, truth))
        np.testing.assert_array_equal(scan.ranges, expected)
    for imu, values in pairs("/imu", "imu"):
        w, a = imu.angular_velocity, imu.linear_acceleration
        assert [w.x, w.y, w.z, a.x, a.y, a.z] == values
        assert imu.orientation_covariance[0] == -1.0
    for odometry, values in pairs("/odom", "odometry"):
        pose, twist = odometry.pose.pose, odometry.twist.twist
        assert (odometry.header.frame_id, odometry.child_frame_id) == ("odom", "base_link")
        assert [pose.position.x, pose.position.y, twist.linear.x, twist.linear.y, twist.angular.z] == [
            *values[:2],
            *values[3:],
        ]
        assert yaw(pose.orientation) == pytest.approx(values[2], abs=1e-12)
    for battery, (voltage, current, charge) in pairs("/battery_state", "battery"):
        assert_same([voltage, -current, charge], battery.voltage, battery.current, battery.percentage)
    for echo, values in pairs("/ultrasonic/left", "ultrasonic_left"):
        measured = echo.max_range if math.isinf(echo.range) else 0.0 if math.isnan(echo.range) else echo.range
        assert_same(values, echo.field_of_view, echo.min_range, echo.max_range, measured)
    for image, (total,) in pairs("/camera/image_raw", "camera"):
        assert (image.encoding, image.step) == ("bgr8", 3 * image.width)
        assert int(image.data.sum(dtype=np.int64)) == total
    for jpeg, image in zip(messages["/camera/image_raw/compressed"], messages["/camera/image_raw"], strict=True):
        assert jpeg.header == image.header
        decoded = np.asarray(Image.open(io.BytesIO(jpeg.data.tobytes())).convert("RGB"))[..., ::-1].astype(float)
        assert np.abs(decoded - image.data.reshape(decoded.shape)).mean() < 6.0
    info = messages["/camera/camera_info"][0]
    spec = threewe.RobotProfile.load(PROFILE).camera
    assert spec is not None
    camera = spec.intrinsics
    assert (info.width, info.height) == (camera.width, camera.height)
    assert list(info.k) == [camera.fx, 0.0, camera.cx - 0.5, 0.0, camera.fy, camera.cy - 0.5, 0.0, 0.0, 1.0]

    # transforms: odometry again, and the truth in the map
    for message, (_, values) in zip(messages["/tf"], samples["odometry"], strict=True):
        odom, world = message.transforms
        assert (odom.header.frame_id, odom.child_frame_id) == ("odom", "base_link")
        assert (world.header.frame_id, world.child_frame_id) == ("map", "odom")
        assert [odom.transform.translation.x, odom.transform.translation.y] == values[:2]
    fixed = {frame.child_frame_id: frame for (message,) in [messages["/tf_static"]] for frame in message.transforms}
    assert {"lidar", "imu", "camera_optical_frame", "base_footprint", "ultrasonic_left"} <= set(fixed)
    mount = threewe.RobotProfile.load(PROFILE).lidar
    assert mount is not None
    assert fixed["lidar"].transform.translation.z == mount.height
    assert 'name="base_link"' in messages["/robot_description"][0].data
    (grid,) = messages["/map"]
    assert set(np.unique(grid.data)) == {-1, 0, 100}
    assert grid.data.size == grid.info.width * grid.info.height


@pytest.mark.nightly
def test_stamped_commands_drive_too(tmp_path: Path) -> None:
    types = {topic: TYPES[topic] for topic in ("/clock", "/odom")}
    commands = "0.2 0 0 40\n"
    with Served("--lockstep", "--seed", "3"):
        messages = record(FIRST_DOMAIN, tmp_path / "record", types, commands, "--drive-stamped /cmd_vel")
    last = messages["/odom"][-1].pose.pose.position.x
    assert last == simulate(SCENE, PROFILE, 3, commands)["odometry"][-1][1][0]
    assert last > 0.05


@pytest.mark.nightly
def test_diagnostics_are_published_once_a_second(tmp_path: Path) -> None:
    types = {"/clock": TYPES["/clock"], "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray"}
    with Served("--lockstep"):
        messages = record(FIRST_DOMAIN, tmp_path / "record", types, "0.2 0 0 160\n", "--drive /cmd_vel")["/diagnostics"]
    assert 2 <= len(messages) <= 4
    stamps = [message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec for message in messages]
    assert np.allclose(np.diff(stamps), 1.0)
    said = {status.name: status.message for status in messages[-1].status}
    assert said["threewe: lidar"] == "ok"
    assert set(said.values()) == {"ok"}


def test_we_drive_what_we_serve(network: pytest.MonkeyPatch) -> None:
    network.setenv("ROS_DOMAIN_ID", str(FIRST_DOMAIN + 1))
    with Served("--scene", SCENE), threewe.sync.Robot(backend="real") as robot:
        result = robot.move_to(x=1.2, y=0.5)
        assert result.success, result
        assert abs(result.pose.x - 1.2) < 0.4
        found = _core.ros2_discover(1.0).endpoints
    (clock,) = [endpoint for endpoint in found if endpoint.topic == "/clock" and endpoint.publishes]
    assert clock.node == "/simulator"
    assert "jazzy" in _core.ros2_distributions_with(clock.type, clock.hash)


@pytest.mark.parametrize("turned", [pytest.param(False, marks=pytest.mark.nightly), True])
def test_a_lidar_that_is_mounted_otherwise_is_named(
    network: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, tmp_path: Path, turned: bool
) -> None:
    network.setenv("ROS_DOMAIN_ID", str(FIRST_DOMAIN + 1))
    mounted = "base_from_lidar: [0.04, 0.0, "
    yaml = threewe.RobotProfile.load(PROFILE).yaml
    assert f"{mounted}0.0]" in yaml
    profile = tmp_path / "changed.yaml"
    profile.write_text(yaml.replace(f"{mounted}0.0]", f"{mounted}1.5708]") if turned else yaml)
    with caplog.at_level("WARNING"), Served("--scene", SCENE), threewe.sync.Robot("real", str(profile)) as robot:
        robot.sleep(2.5)
    assert ("by /tf_static it is at" in caplog.text) == turned, caplog.text


@pytest.mark.nightly
def test_several_robots_have_namespaces(network: pytest.MonkeyPatch) -> None:
    network.setenv("ROS_DOMAIN_ID", str(FIRST_DOMAIN + 2))
    with Served("--robot", PROFILE, "--robot", "turtlebot_like"):
        found = [endpoint for endpoint in _core.ros2_discover(2.0).endpoints if endpoint.publishes]
    scans = {endpoint.topic: endpoint.node for endpoint in found if endpoint.topic.endswith("/scan")}
    assert scans == {"/robot_1/scan": "/robot_1/simulator", "/robot_2/scan": "/robot_2/simulator"}
    assert [endpoint.topic for endpoint in found].count("/clock") == 1


def test_messages_of_all_types_reach_another_dds_and_come_back(tmp_path: Path) -> None:
    """Bytes of rosbags, written again by us, sent by Cyclone DDS, recorded by Fast DDS and sent back."""
    domain = str(FIRST_DOMAIN + 2)
    names = {kind.split("/")[-1]: kind for kind in _core.ros2_message_types()}
    topics = [f"/types/{name}={dds_type(kind)}" for name, kind in names.items()]
    echo = [str(PROGRAMS / "ros2_recorder"), domain, str(tmp_path / "record"), "--echo", *topics]
    corpus = ROOT / "tests/fuzz/corpus/message"
    with subprocess.Popen(echo, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL) as other:
        done = subprocess.run([PROGRAMS / "ros2_exchange", domain, corpus], capture_output=True, text=True, timeout=60)
        other.terminate()
    assert done.stdout == f"{len(names)} of {len(names)} types\n", done


@pytest.mark.nightly
def test_an_autonomy_stack_shows_its_map_and_drives_to_goals(network: pytest.MonkeyPatch, tmp_path: Path) -> None:
    domain = FIRST_DOMAIN + 2
    network.setenv("ROS_DOMAIN_ID", str(domain))
    types = {"/plan": "nav_msgs/msg/Path", "/map": "nav_msgs/msg/OccupancyGrid"}
    # localised by what it says of itself, and commanded to stand all the while
    with Served("--autonomy"), threewe.sync.Robot("real", localization="slam_toolbox") as robot:
        assert np.count_nonzero(robot.get_map().data == 100) > 100
        assert robot.health["slam_toolbox"].detail.startswith("it states no covariance")
        messages = record(
            domain, tmp_path / "record", types, "0 0 0 150\n", "--drive /cmd_vel --goal 1.2,0.4", kept=("/map",)
        )
        for _ in range(100):
            pose = robot.get_pose()
            if math.hypot(pose.x - 1.2, pose.y - 0.4) < 0.15:
                break
            robot.sleep(0.1)
        assert math.hypot(pose.x - 1.2, pose.y - 0.4) < 0.15
        robot.sleep(2.0)  # what its wheels do without being commanded is over
        # a velocity that is none ends no drive, any other does
        robot.set_velocity(0.0, 0.0, 0.4, hold=1.0)
        robot.sleep(1.2)
        assert robot.get_pose().theta - pose.theta > 0.2
    plan = messages["/plan"][0]
    assert plan.header.frame_id == "map"
    end = plan.poses[-1].pose.position
    assert math.hypot(end.x - 1.2, end.y - 0.4) < 0.1
    assert not messages["/plan"][-1].poses or len(messages["/plan"]) > 1


def serve(**changes: Any) -> None:
    _core.ros2_serve(**{"scene": SCENE, "robots": [PROFILE], "namespaces": [""], **changes})


def test_what_cannot_be_served_is_named() -> None:
    with pytest.raises(ConfigError, match="the scene's map and the robot's own are one topic"):
        serve(map=True, autonomy=True)
    with pytest.raises(ConfigError, match="2 namespaces for 1 robots"):
        serve(namespaces=["", "/b"])
    with pytest.raises(ConfigError, match="namespace '/a-b'; expected one such as /robot_1"):
        serve(namespaces=["/a-b"])
    with pytest.raises(ConfigError, match="two robots in namespace '/a'"):
        serve(robots=[PROFILE, PROFILE], namespaces=["/a", "/a"])
    with pytest.raises(ConfigError, match=r"speed is -1.* 0 being as fast as can be"):
        serve(speed=-1.0)


def test_the_command_line_ends_and_states_both_times() -> None:
    program = "from threewe.cli import main; main()"
    command = [sys.executable, "-c", program, "ros2", "serve", "--speed", "0", "--seconds", "0.3"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "s of robot time in" in done.stdout
