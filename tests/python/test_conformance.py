"""`threewe.testing.check_backend`: what it shows and raises, and who passes it."""

from __future__ import annotations

import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import threewe
from threewe import ConfigError, ContractError, Features, SensorInfo, SensorType, Velocity
from threewe.backend import CameraReading, Reading
from threewe.testing import Outcome, check_backend, check_names

from .toy_backend import QuietBackend


class RealtimeBackend(QuietBackend):
    """Time is the wall clock."""

    lockstep = False


REALTIME_CHECKS = [
    "connecting_twice_does_nothing",
    "connecting_again_works",
    "time_starts_at_zero",
    "time_never_goes_back",
    "command_returns_at_once",
    "samples_arrive_in_order",
    "received_is_the_time_of_the_poll",
    "measured_before_received",
    "samples_are_recent",
    "a_metre_driven_is_a_metre_in_odometry",
    "an_expired_command_stops_the_robot",
    "a_refused_command_changes_nothing",
]
"""Those of which time is the essence. All of them take a minute and a half, for time cannot be hurried."""


class LyingBackend(QuietBackend):
    """Claims a lidar of 10 Hz and odometry of 50 Hz, and delivers both at 50 Hz."""

    rates = (10.0, 50.0, 50.0)


def test_the_mock_backend_passes() -> None:
    results = check_backend("mock", scene="corridor_v1", show=False, raise_failures=True)
    assert [result.name for result in results] == check_names()
    assert len(results) >= 45


def test_a_backend_in_python_passes() -> None:
    threewe.register_backend("quiet", QuietBackend)
    results = check_backend("quiet", show=False)
    assert {result.name: result.detail for result in results if not result.passed} == {}
    assert sum(result.outcome == Outcome.passed for result in results) >= 40


def test_a_backend_in_real_time_passes() -> None:
    threewe.register_backend("realtime", RealtimeBackend)
    with ThreadPoolExecutor(4) as pool:
        jobs = [pool.submit(check_backend, "realtime", checks=[name], show=False) for name in REALTIME_CHECKS]
    results = [result for job in jobs for result in job.result()]
    assert [(result.name, result.outcome, result.detail) for result in results] == [
        (name, Outcome.passed, "") for name in REALTIME_CHECKS
    ]


def test_a_failure_is_shown_and_raised_with_what_was_wrong(capsys: pytest.CaptureFixture[str]) -> None:
    threewe.register_backend("lying", LyingBackend)
    checks = ["sensor_rates_are_positive", "rates_are_as_listed"]
    with pytest.raises(
        ContractError, match="backend 'lying' fails 1 of 2 checks:\n  rates_are_as_listed: sensor 'lidar'"
    ):
        check_backend("lying", checks=checks, raise_failures=True)
    shown = capsys.readouterr().out
    assert "sensor_rates_are_positive" in shown
    assert "failed" in shown
    good, bad = check_backend("lying", checks=checks, show=False)
    assert (good.passed, bad.passed) == (True, False)
    assert repr(good) == "CheckResult('sensor_rates_are_positive', passed)"


class WallClockBackend(QuietBackend):
    """Stamps with the time of day."""

    def readings(self, t: float, velocity: Velocity) -> list[Reading]:
        return [replace(reading, measured=1763900000.0 + t) for reading in super().readings(t, velocity)]


def test_one_error_at_many_checks_is_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    threewe.register_backend("wall_clock", WallClockBackend)
    with pytest.raises(ContractError, match="backend 'wall_clock' fails") as error:
        check_backend("wall_clock", raise_failures=True)
    told = str(error.value)
    assert told.count("which is probably wall-clock time") == 1
    assert re.search(r"\(the same at \d\d more checks\)", told)
    shown = " ".join(capsys.readouterr().out.split())
    assert shown.count("the same at") == 1
    assert shown.count("│ as ") >= 30


def test_a_colour_that_is_stated_tells_blue_from_red() -> None:
    class Sighted(QuietBackend):
        """Sees a red sheet; `order` is how it orders blue, green and red."""

        order = (0, 1, 2)

        @property
        def features(self) -> Features:
            quiet = super().features
            return Features(
                [*quiet.sensors, SensorInfo("camera", SensorType.camera, 50.0)], quiet.kinematics, lockstep=True
            )

        def readings(self, t: float, velocity: Velocity) -> list[Reading]:
            camera = self.profile.camera
            assert camera is not None
            size = camera.intrinsics
            color = np.full((size.height, size.width, 3), (30, 30, 200), np.uint8)[..., list(self.order)]
            return [*super().readings(t, velocity), CameraReading(measured=t, color=color)]

    threewe.register_backend("sighted", Sighted)
    threewe.register_backend("swapped", type("Swapped", (Sighted,), {"order": (2, 1, 0)}))

    def outcome(backend: str, color: str) -> tuple[Outcome, str]:
        checks = ["images_are_blue_green_red"]
        (result,) = check_backend(backend, hardware="3we_standard_v2", checks=checks, color_ahead=color, show=False)
        return result.outcome, result.detail

    assert outcome("sighted", "red") == (Outcome.passed, "")
    assert outcome("swapped", "blue") == (Outcome.passed, "")
    for backend, color in [("swapped", "red"), ("sighted", "blue")]:
        found, detail = outcome(backend, color)
        assert found == Outcome.failed
        assert "channel 0 must be blue, 2 red" in detail
    found, detail = outcome("swapped", "")
    assert found == Outcome.not_applicable
    assert "put something red or blue there, and state it (color_ahead)" in detail
    with pytest.raises(ConfigError, match="color_ahead is 'green'; it must be 'red' or 'blue'"):
        outcome("sighted", "green")


def test_unknown_names_are_errors_with_the_nearest_right_one() -> None:
    with pytest.raises(ConfigError, match="unknown backend 'mok'; did you mean 'mock'"):
        check_backend("mok", show=False)
    with pytest.raises(ConfigError, match="unknown check 'time_starts_at_zro'; did you mean 'time_starts_at_zero'"):
        check_backend("mock", checks=["time_starts_at_zro"], show=False)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"backend": 3}, "backend must be a string, got 3"),
        ({"scene": None}, "scene must be a string, got None"),
        ({"seed": -1}, "seed must be a whole number"),
        ({"checks": "time_starts_at_zero"}, "checks must be a list, got 'time_starts_at_zero'"),
    ],
)
def test_arguments_of_a_wrong_type(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ContractError, match=message):
        check_backend(**{"backend": "mock", "show": False, **options})


def test_registering_what_is_no_backend() -> None:
    with pytest.raises(ContractError, match="name must be a string, got None"):
        threewe.register_backend(None, QuietBackend)  # type: ignore[arg-type]
    with pytest.raises(ContractError, match="factory must be a function, got 3"):
        threewe.register_backend("three", 3)  # type: ignore[arg-type]
    assert "three" not in threewe.backend_names()


def test_a_backend_that_cannot_be_made_fails_with_the_reason() -> None:
    threewe.register_backend("none", lambda _: None)  # type: ignore[arg-type, return-value]
    (result,) = check_backend("none", checks=["time_starts_at_zero"], show=False)
    assert not result.passed
    assert result.detail == "ContractError: backend 'none': its factory made a NoneType, not a threewe.backend.Backend"
