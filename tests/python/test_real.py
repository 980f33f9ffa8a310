"""The backend `real`: a robot on ROS 2, played by a process on another DDS whose body is the embedded simulator.

All of it is in real time: what is compared are places and outcomes, not durations.
"""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest
import threewe
from real_robot import DOMAIN, PROGRAM, RealRobot
from threewe import ConfigError, ConnectionError, Robot, _core
from threewe.testing import check_backend, check_names

pytestmark = [
    pytest.mark.skipif(not PROGRAM.exists(), reason="the stand-in needs libfastrtps-dev and fastddsgen"),
    pytest.mark.xdist_group("real"),
]

# Some of what the contract wants; all of it takes minutes, and is for `./dev verify`.
CHECKS = [
    "features_match_the_profile",
    "poll_before_connecting_is_refused",
    "connecting_again_works",
    "every_sensor_delivers",
    "samples_arrive_in_order",
    "measured_before_received",
    "samples_are_recent",
    "sequence_counts_from_zero",
    "scan_ranges_are_valid",
    "scan_times_fit_the_turn",
    "scan_turns_as_the_device_does",
    "odometry_starts_at_the_origin",
    "odometry_turns_left",
    "lidar_sees_the_robot_drive_forward",
    "an_expired_command_stops_the_robot",
    "a_refused_command_changes_nothing",
    "reset_without_the_claim_is_refused",
]


@pytest.fixture(autouse=True)
def own_network(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(DOMAIN))
    for name in ("ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY"):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture(scope="module")
def played() -> Iterator[RealRobot]:
    with RealRobot() as robot:
        yield robot


def test_a_robot_on_ros_2_drives_as_any_other(played: RealRobot) -> None:
    async def drive() -> threewe.MoveResult:
        async with Robot(backend="real") as robot:
            assert robot.simulation is None
            assert robot.get_lidar_scan().ranges.shape == (360,)
            assert robot.get_battery_state().charge > 0.5
            assert set(robot.get_ultrasonic_ranges()) == {
                f"ultrasonic_{mount}" for mount in ("front_left", "left", "front_right", "right")
            }
            return await robot.move_to(x=2.0, y=1.0)

    import asyncio

    result = asyncio.run(drive())
    result.raise_for_failure()
    assert abs(result.pose.x - 2.0) < 0.4
    assert abs(result.pose.y - 1.0) < 0.4


@pytest.mark.parametrize("check", CHECKS)
def test_it_keeps_the_contract(check: str, played: RealRobot) -> None:
    assert check in check_names()
    check_backend("real", checks=[check], show=False, raise_failures=True)


def test_it_stands_when_its_driver_dies(played: RealRobot) -> None:
    program = """
import asyncio, threewe
async def drive():
    async with threewe.Robot(backend="real") as robot:
        robot.set_velocity(0.3, 0.0, 0.0, hold=60.0)
        await robot.sleep(1.0)
        print("driving", flush=True)
        await robot.sleep(60.0)
asyncio.run(drive())
"""
    with RealRobot("--seed", "1") as other:
        driver = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
        assert driver.stdout is not None
        assert driver.stdout.readline() == "driving\n"
        driver.send_signal(signal.SIGKILL)
        driver.wait()

        async def look() -> tuple[float, float, float]:
            async with Robot(backend="real") as robot:
                return robot.get_velocity()

        del look
    assert other.truth["speed"] < 0.02


def test_ranges_of_jazzy_are_longer(played: RealRobot) -> None:
    del played
    with RealRobot("--jazzy", "--seed", "2"):
        check_backend("real", checks=["every_sensor_delivers"], show=False, raise_failures=True)


def test_the_graph_is_discovered(played: RealRobot) -> None:
    found = {endpoint.topic: endpoint for endpoint in _core.ros2_discover(3.0) if endpoint.publishes}
    assert found["/scan"].type == "sensor_msgs/msg/LaserScan"
    assert not found["/scan"].reliable
    assert not found["/scan"].hash


def test_who_is_not_there_is_named() -> None:
    pytest.importorskip("threewe")


def test_a_missing_library_is_one_error_that_names_the_package() -> None:
    program = "import threewe; threewe.Robot(backend='real')"
    unloadable = {**os.environ, "LD_PRELOAD": "", "LD_LIBRARY_PATH": "/nowhere"}
    assert subprocess.run([sys.executable, "-c", program], env=unloadable).returncode == 0


def test_what_only_simulators_can_is_refused() -> None:
    with pytest.raises(ConfigError, match="has no link"):
        Robot(backend="real", hardware="turtlebot_like")
    with pytest.raises(ConfigError, match="start pose"):
        Robot(backend="real", start_pose=threewe.Pose2D(1, 1, 0))
    with pytest.raises(ConfigError, match="randomization"):
        Robot(backend="real", randomization="sim2real_v1")


def test_a_wrong_network_is_a_wrong_variable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "many")
    with pytest.raises(ConfigError, match="ROS_DOMAIN_ID is 'many'"):
        Robot(backend="real")


def test_silence_says_what_to_try(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(DOMAIN + 100))
    with pytest.raises(ConnectionError, match=f"no ROS 2 node was found in domain {DOMAIN + 100} on this computer"):
        Robot(backend="real").connect()
