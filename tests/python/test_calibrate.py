"""The embedded simulator fitted to another robot, as users see it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path

import command_line
import pytest
import threewe
import threewe.sync
from threewe import Velocity, _core
from threewe._core import VelocityProfile
from threewe.backend import Reading, known_backend, register_backend
from toy_backend import QuietBackend

FITTED = Path(threewe.asset_directories()[0]) / "calibration"

needs_mujoco = pytest.mark.skipif(find_spec("mujoco") is None, reason="not shown: mujoco-core is not installed")


@needs_mujoco
@pytest.mark.parametrize("hardware", ["3we_standard_v2", "turtlebot_like"])
def test_once_fitted_it_moves_as_mujoco_does(hardware: str) -> None:
    profiles = [threewe.RobotProfile.load(name) for name in (hardware, str(FITTED / f"{hardware}_mujoco.yaml"))]
    plain, fitted = _core.deviations(
        known_backend("mujoco"), hardware, profiles, 1_000_000, 4, VelocityProfile.operating
    )
    assert fitted.linear < 0.05
    assert fitted.angular < 0.05
    assert fitted.pose < 0.03
    assert fitted.combined < 0.7 * plain.combined


@needs_mujoco
def test_a_calibration_leaves_a_profile_that_a_robot_takes(tmp_path: Path) -> None:
    file = tmp_path / "fitted.yaml"
    found = threewe.calibrate("mujoco", "turtlebot_like", output=file)
    assert found.source == "truth"
    assert found.after.linear < 0.6 * found.before.linear
    known = {figure.name: figure for figure in found.figures}
    assert known["motor_lag"].identifiable
    assert known["motor_lag"].value == pytest.approx(0.0377, abs=0.001)  # as it was shipped
    with threewe.sync.Robot(hardware=str(file)) as robot:
        assert robot.move_to(x=1.0, y=0.3).success


def test_a_standard_robot_with_a_measured_drive_arrives() -> None:
    with threewe.sync.Robot(hardware=str(FITTED / "3we_standard_v2_mujoco.yaml")) as robot:
        assert robot.move_to(x=2.0, y=1.0).success


def test_mistakes_are_told(tmp_path: Path) -> None:
    with pytest.raises(threewe.ConfigError, match=r"\.yaml"):
        threewe.calibrate("mock", output=tmp_path / "fitted.txt")
    with pytest.raises(threewe.ConfigError, match="did you mean 'mujoco'"):
        threewe.calibrate("mujocco")


def test_the_command_says_what_it_found(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    words = ["calibrate", "--backend", "mock", "--hardware", "turtlebot_like", "-o", str(file)]
    done = command_line.threewe(*words)
    assert done.returncode == 0, done.stderr
    assert "motor_lag" in done.stdout
    assert "linear velocity" in done.stdout
    assert threewe.RobotProfile.load(str(file)).name == "mine"


class LaggingBackend(QuietBackend):
    """A robot that tells no truth, and obeys with a lag of 50 ms."""

    lagging = Velocity()

    def step(self, t: float, velocity: Velocity) -> Iterable[Reading]:
        share = 1.0 - math.exp(-(t - self.now) / 0.05)
        pairs = zip(self.lagging, velocity, strict=True)
        self.lagging = Velocity(*(was + share * (told - was) for was, told in pairs))
        return super().step(t, self.lagging)


def test_a_robot_without_truth_is_calibrated_by_its_wheels_and_gyro() -> None:
    register_backend("lagging", LaggingBackend)
    found = threewe.calibrate("lagging")
    known = {figure.name: figure for figure in found.figures}
    assert found.source == "sensors"
    assert known["motor_lag"].value == pytest.approx(0.05, abs=0.01)
    assert known["traction.turning_lag"].value == pytest.approx(0.05, abs=0.01)
    assert found.after.combined < 0.5 * found.before.combined
