"""The backend `real` where other programs localise and drive the robot: both are played by processes on another DDS.

All of it is in real time: what is compared are places, outcomes and words, not durations.
"""

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import threewe
import threewe.sync
from real_robot import FIRST_DOMAIN, NAV2, Nav2, RealRobot
from threewe import ConfigError, ConnectionError, ContractError, LocalizationState, MoveResult, Reason, Zone

pytestmark = [
    pytest.mark.skipif(not NAV2.exists(), reason="the stand-ins need libfastrtps-dev and fastddsgen"),
    pytest.mark.flaky(reruns=1),  # in real time: a loaded machine may be late once, what is wrong fails each time
]


@pytest.fixture(autouse=True)
def network(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(FIRST_DOMAIN))
    for name in ("ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY"):
        monkeypatch.delenv(name, raising=False)
    return monkeypatch


@dataclass
class Place:
    """A robot with Nav2 and SLAM Toolbox, and what is connected to them."""

    nav2: Nav2
    robot: threewe.sync.Robot

    def away(self, x: float, y: float) -> float:
        pose = self.robot.get_pose()
        return math.hypot(pose.x - x, pose.y - y)

    def go_back(self) -> None:
        """To the start of the scene, so that no test depends on the one before."""
        self.nav2.set("normal")
        sleep_until(self.robot, lambda: all(self.robot.health[name].ok for name in ("imu", "odometry", "lidar")))
        if self.away(0.0, 0.0) > 0.3:
            assert self.robot.move_to(0.0, 0.0).success


@pytest.fixture(scope="module")
def connected() -> Iterator[Place]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(FIRST_DOMAIN))
        robot = threewe.sync.Robot("real", localization="slam_toolbox", navigation="nav2")
    with RealRobot(FIRST_DOMAIN, "--truth"), Nav2(FIRST_DOMAIN) as nav2, robot:
        yield Place(nav2, robot)


@pytest.fixture
def place(connected: Place) -> Place:
    connected.go_back()
    return connected


def sleep_until(robot: threewe.sync.Robot, condition: Callable[[], bool]) -> None:
    for _ in range(200):
        if condition():
            return
        robot.sleep(0.1)
    pytest.fail("it has not come true within 20 s")


def speed(robot: threewe.sync.Robot) -> float:
    velocity = robot.get_velocity()
    return math.hypot(velocity.vx, velocity.vy)


def failed(place: Place, mode: str) -> MoveResult:
    """How a goal ends that is treated so."""
    place.nav2.set(mode)
    result = place.robot.move_to(1.5, 0.0)
    assert not result.success, result
    place.robot.sleep(0.3)
    assert speed(place.robot) < 0.05
    return result


def test_pose_covariance_map_and_health_are_those_of_the_program(place: Place) -> None:
    robot = place.robot
    assert (robot.localization, robot.navigation) == ("slam_toolbox", "nav2")
    assert place.away(0.0, 0.0) < 0.35
    grid = robot.get_map()
    assert grid.resolution == 0.05
    assert np.count_nonzero(grid.data == 100) > 1000
    assert robot.health["slam_toolbox"].ok
    assert robot.health["nav2"].ok
    assert robot.localization_state == LocalizationState.tracking
    result = robot.move_forward(0.2)  # by our own navigator
    assert result.success, result
    # of the covariance that the stand-in states, [[4, 1], [1, 4]] cm^2: between those of discs along its axes
    assert 2.4477 * math.sqrt(3e-4) < result.position_uncertainty < 2.4477 * math.sqrt(5e-4)


def test_nav2_drives_and_tells_how_far_it_has_come(place: Place) -> None:
    robot = place.robot
    left: list[float] = []
    result = robot.move_to(1.5, 0.5, on_progress=lambda progress: left.append(progress.distance_left))
    assert result.success, result
    assert place.away(1.5, 0.5) < 0.35
    assert result.distance > 1.0
    assert left[0] > 1.0
    assert left[-1] < 0.5
    assert all(later < earlier + 0.2 for earlier, later in itertools.pairwise(left))


def test_a_path_is_followed(place: Place) -> None:
    result = place.robot.follow_path([(0.8, 0.0), (0.8, 0.6)])
    assert result.success, result
    assert place.away(0.8, 0.6) < 0.35


@pytest.mark.nightly
def test_waypoints_are_driven_to_one_after_the_other(place: Place) -> None:
    """Around a corner that no straight line leads around; how far it has come is said as it goes."""
    left: list[float] = []
    result = place.robot.follow_waypoints(
        [(0.7, 0.0), (0.7, 0.5, math.pi), (0.0, 0.4)], on_progress=lambda progress: left.append(progress.distance_left)
    )
    assert result.success, result
    assert place.away(0.0, 0.4) < 0.35
    assert result.distance > 1.2
    assert left[0] > 1.7
    assert left[-1] < 0.5


@pytest.mark.nightly
def test_a_waypoint_that_is_missed_ends_them_and_says_which_and_why(place: Place) -> None:
    place.nav2.set("fail 206")
    result = place.robot.follow_waypoints([(0.7, 0.0), (0.7, 0.5)])
    assert result.reason == Reason.no_path
    assert "waypoint 1 of 2 was missed, where it stopped: GOAL_OCCUPIED (206)" in result.detail
    place.nav2.set("normal")
    result = place.robot.follow_waypoints([(0.5, 0.0), (500.0, 0.0)])
    assert result.reason == Reason.no_path
    assert "waypoint 2 of 2 was missed" in result.detail
    assert place.away(0.5, 0.0) < 0.35


@pytest.mark.nightly
def test_waypoints_that_were_left_out_are_no_success(place: Place) -> None:
    """As Nav2 does where it is configured not to stop."""
    place.nav2.set("miss 105")
    result = place.robot.follow_waypoints([(0.9, 0.6), (0.6, 0.0)])
    assert result.reason == Reason.blocked
    assert "waypoint 1 of 2 was missed: FAILED_TO_MAKE_PROGRESS (105)" in result.detail
    assert place.away(0.6, 0.0) < 0.35


@pytest.mark.nightly
def test_waypoints_that_are_wanted_no_more_are_cancelled_there(place: Place) -> None:
    robot = place.robot
    with pytest.raises(ZeroDivisionError):
        robot.follow_waypoints(
            [(2.0, 0.0), (0.0, 0.0)], on_progress=lambda progress: 1 / (progress.distance_driven < 0.2)
        )
    robot.sleep(1.0)
    assert speed(robot) < 0.05
    assert robot.health["nav2"].ok


def test_a_cancelled_goal_is_cancelled_there(place: Place) -> None:
    robot = place.robot
    with pytest.raises(ZeroDivisionError):
        robot.move_to(2.0, 0.0, on_progress=lambda progress: 1 / (progress.distance_driven < 0.2))
    robot.sleep(1.0)
    assert speed(robot) < 0.05
    assert place.away(2.0, 0.0) > 1.0
    assert robot.health["nav2"].ok  # it has ended the goal


@pytest.mark.parametrize(
    ("code", "reason", "words"),
    [
        (208, Reason.no_path, "there is no path to the goal"),
        (0, Reason.cancelled, "another goal may have taken its place"),
        *(
            pytest.param(*by_night, marks=pytest.mark.nightly)
            for by_night in (
                (102, Reason.lost, "no transform to where the robot is"),
                (104, Reason.blocked, "PATIENCE_EXCEEDED"),
                (105, Reason.blocked, "the robot does not get on"),
                (204, Reason.no_path, "the goal is outside of the map"),
                (206, Reason.no_path, "the goal is in an obstacle"),
                (714, Reason.blocked, "backing up would collide"),
                (9001, Reason.fault, "FAILED_TO_LOAD_BEHAVIOR_TREE"),
                (9003, Reason.timeout, "the navigator took too long"),
                (12345, Reason.fault, "error code 12345, which is not one of Nav2's own"),
            )
        ),
    ],
)
def test_an_error_code_is_a_reason_and_words(place: Place, code: int, reason: Reason, words: str) -> None:
    result = failed(place, f"fail {code}")
    assert result.reason == reason
    assert words in result.detail
    assert "as it was asked to" in result.detail  # what Nav2 says of it


@pytest.mark.nightly
def test_an_error_of_a_path_is_one_too(place: Place) -> None:
    place.nav2.set("fail 103")
    result = place.robot.follow_path([(0.8, 0.0), (0.8, 0.6)])
    assert result.reason == Reason.no_path
    assert "INVALID_PATH (103)" in result.detail


@pytest.mark.nightly
def test_a_goal_that_is_rejected_or_cancelled_by_others_says_so(place: Place) -> None:
    rejected = failed(place, "reject")
    assert (rejected.reason, rejected.detail) == (Reason.fault, "Nav2: /navigate_to_pose has rejected the goal")
    cancelled = failed(place, "cancel")
    assert cancelled.reason == Reason.cancelled, cancelled
    assert "cancelled by another program" in cancelled.detail


def test_a_place_that_is_closed_has_no_path(place: Place) -> None:
    result = place.robot.move_to(500.0, 0.0)
    assert result.reason == Reason.no_path


@pytest.mark.nightly
def test_a_slow_server_is_waited_for_and_a_deaf_one_is_not(place: Place) -> None:
    place.nav2.set("slow 1")
    assert place.robot.move_to(0.6, 0.0).success
    deaf = failed(place, "deaf")
    assert deaf.reason == Reason.fault
    assert "has not answered for 3 s" in deaf.detail


@pytest.mark.nightly
def test_without_feedback_it_counts_as_dead(place: Place) -> None:
    mute = failed(place, "mute")
    assert mute.reason == Reason.fault
    assert "no feedback for 2 s" in mute.detail


@pytest.mark.nightly
def test_a_motion_that_is_ours_waits_for_a_transform_that_stops_coming(
    network: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Nav2 is there, and may publish velocities, which the profile permits."""
    domain = FIRST_DOMAIN + 1
    network.setenv("ROS_DOMAIN_ID", str(domain))
    yaml = threewe.RobotProfile.load("3we_standard_v2").yaml
    profile = tmp_path / "shared.yaml"
    profile.write_text(yaml.replace("msg/Twist}", "msg/Twist, shared: true}"))
    with (
        RealRobot(domain, "--truth") as other,
        Nav2(domain, "--amcl") as nav2,
        threewe.sync.Robot("real", str(profile), localization="amcl", initial_pose=(0.1, 0.2, 0.3)) as robot,
    ):
        assert nav2.line() == "0.100 0.200 0.300"
        assert robot.move_to(0.5, 0.0).success
        nav2.set("lost")
        sleep_until(robot, lambda: not robot.health["amcl"].ok)
        assert "no transform map -> odom for " in robot.health["amcl"].detail
        assert robot.localization_state == LocalizationState.lost
        result = robot.move_to(1.2, 0.0)
        assert result.reason == Reason.lost
        assert "amcl: no transform map -> odom for " in result.detail
        assert result.distance < 0.05
        nav2.set("normal")
        sleep_until(robot, lambda: robot.health["amcl"].ok)
        result = robot.move_to(1.2, 0.0)
        assert result.success, result
        other.process.terminate()
        other.process.wait(30)
    assert math.hypot(other.truth["pose"][0] - 1.2, other.truth["pose"][1]) < 0.3


def test_nav2_that_dies_leaves_the_robot_standing(network: pytest.MonkeyPatch) -> None:
    domain = FIRST_DOMAIN + 2
    network.setenv("ROS_DOMAIN_ID", str(domain))
    with RealRobot(domain, "--truth"):
        nav2 = Nav2(domain)
        nav2.__enter__()
        with threewe.sync.Robot("real", localization="slam_toolbox", navigation="nav2") as robot:
            killed = False

            def kill(progress: threewe.Progress) -> None:
                nonlocal killed
                if progress.distance_driven > 0.2 and not killed:
                    killed = True
                    nav2.process.kill()

            result = robot.move_to(2.0, 0.0, on_progress=kill)
            assert killed
            assert result.reason == Reason.fault
            assert "no feedback for 2 s: Nav2 has died" in result.detail
            assert speed(robot) < 0.05
            assert robot.get_pose().x < 1.2
        nav2.process.communicate(timeout=30)


@pytest.mark.nightly
@pytest.mark.parametrize("options", [("--humble",), ("--cyclone",), ("--humble", "--cyclone")])
def test_other_layouts_and_services_are_spoken(network: pytest.MonkeyPatch, options: tuple[str, ...]) -> None:
    """Results without error codes, and requests and replies that begin with who asked."""
    domain = FIRST_DOMAIN + 2
    network.setenv("ROS_DOMAIN_ID", str(domain))
    with (
        RealRobot(domain, "--truth"),
        Nav2(domain, *options) as nav2,
        threewe.sync.Robot("real", localization="slam_toolbox", navigation="nav2") as robot,
    ):
        result = robot.move_to(0.6, 0.0)
        assert result.success, result
        assert robot.follow_path([(0.2, 0.0)]).success
        assert robot.follow_waypoints([(0.5, 0.0), (0.2, 0.0)]).success
        nav2.set("fail 208")
        missed = robot.follow_waypoints([(0.6, 0.0), (0.2, 0.0)])
        assert "waypoint 1 of 2 was missed" in missed.detail
        assert missed.reason == (Reason.blocked if "--humble" in options else Reason.no_path)
        result = robot.move_to(1.5, 0.0)
        if "--humble" in options:
            assert result.reason == Reason.blocked
            assert "in Humble it does not state why" in result.detail
        else:
            assert result.reason == Reason.no_path
    assert nav2.asked["goals"] == 5


@pytest.mark.nightly
def test_what_is_not_there_is_named(network: pytest.MonkeyPatch) -> None:
    domain = FIRST_DOMAIN + 1
    network.setenv("ROS_DOMAIN_ID", str(domain))
    with RealRobot(domain):
        robot = threewe.sync.Robot("real", localization="amcl", navigation="nav2")
        with pytest.raises(ConnectionError) as raised, robot:
            pass
    text = str(raised.value)
    assert "localization 'amcl': no transform map -> odom has come on /tf; it may need an initial_pose" in text
    assert "no map has come on /map" in text
    assert "navigation 'nav2': no node serves the action /navigate_to_pose: is Nav2 running and active?" in text


def test_what_cannot_be_delegated_is_refused() -> None:
    with pytest.raises(ConfigError, match="navigation 'nav2' has its goals in the map of 'amcl' or 'slam_toolbox'"):
        threewe.sync.Robot("real", navigation="nav2")
    with pytest.raises(ConfigError, match="localization 'amcl' is a program on a robot: backend 'real' reaches it"):
        threewe.sync.Robot("mock", localization="amcl")
    with pytest.raises(ConfigError, match="unknown navigation 'nav'; did you mean 'nav2'"):
        threewe.sync.Robot("real", localization="amcl", navigation="nav")
    grid = threewe.OccupancyGrid(np.zeros((4, 4), np.int8), 0.05, (0.0, 0.0))
    with pytest.raises(ConfigError, match="map: with localization 'amcl' the map is the one that it has"):
        threewe.sync.Robot("real", localization="amcl", map=grid)


def test_zones_belong_to_nav2(place: Place) -> None:
    zone = Zone([(1, 1), (2, 1), (2, 2)])
    with pytest.raises(ContractError, match="zones: 'nav2' plans by its own costmaps"):
        place.robot.set_zones([zone])
