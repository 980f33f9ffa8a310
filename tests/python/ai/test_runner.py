"""A policy drives a robot, and stops it, whatever becomes of the policy."""

from __future__ import annotations

import asyncio
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ai import policies
from threewe import ConfigError, ContractError, EmergencyStopError, HardwareError, Kinematics, Robot, SafetyError
from threewe.ai import PolicyResult, VLARunner

SIZE = (policies.HEIGHT, policies.WIDTH)


def runner_of(folder: Path, velocity: tuple[float, float, float] = (0.2, 0.0, 0.0), **changes: Any) -> VLARunner:
    return VLARunner.from_pretrained(policies.write(folder / "policy", policies.graph(velocity), **changes))


async def drive(runner: VLARunner, timeout: float = 2.0) -> tuple[PolicyResult, list[tuple[float, ...]]]:
    """A run, and what was commanded in each tick."""
    commands: list[tuple[float, ...]] = []
    async with Robot(image_size=SIZE) as robot:
        robot.observe(lambda tick: commands.append(tuple(tick.requested)))
        result = await runner.run(robot, "go to the chair", timeout=timeout)
        await robot.move_forward(0.1)  # the robot is usable at once
    return result, commands


def test_it_drives_until_the_time_is_up_and_then_stands(tmp_path: Path) -> None:
    result, commands = asyncio.run(drive(runner_of(tmp_path)))
    assert (result.reason, result.success) == ("timeout", False)
    assert result.duration == pytest.approx(2.0)
    assert result.inferences > 10
    assert max(v[0] for v in commands[:100]) == pytest.approx(0.2, abs=1e-6)


def test_a_policy_that_stands_still_has_reached_its_goal(tmp_path: Path) -> None:
    result, _ = asyncio.run(drive(runner_of(tmp_path, (0.0, 0.0, 0.0))))
    assert (result.reason, result.success) == ("reached", True)
    assert result.duration == pytest.approx(0.6, abs=0.05)


def test_two_runs_in_lockstep_are_the_same(tmp_path: Path) -> None:
    runner = VLARunner.from_pretrained(policies.write(tmp_path / "policy", policies.graph(red=0.3)))
    first, second = (asyncio.run(drive(runner)) for _ in range(2))
    assert first == second
    assert len(set(first[1])) > 20  # what it commands depends on the pictures


def test_actions_are_applied_a_fixed_time_after_their_inference_began(tmp_path: Path) -> None:
    for latency in (0.0, 0.3):
        _, commands = asyncio.run(drive(runner_of(tmp_path, latency=latency)))
        begun = next(i for i, v in enumerate(commands) if v[0] > 0)
        assert begun == pytest.approx(latency / 0.02, abs=2)


def test_red_in_front_of_the_camera_is_red_in_the_tensor(tmp_path: Path) -> None:
    red = np.zeros((*SIZE, 3), np.uint8)
    red[:, :, 2] = 255  # BGR
    for color, ahead in (("rgb", 1.0), ("bgr", 0.0)):
        camera = {**policies.DESCRIPTION["cameras"][0], "color": color}
        folder = policies.write(tmp_path / color, policies.graph((0.0, 0.0, 0.0), red=1.0), cameras=[camera])
        runner = VLARunner.from_pretrained(folder)
        assert runner.predict(red, "go to the chair") == pytest.approx([ahead, 0.0, 0.0])
        twice = np.repeat(np.repeat(red, 2, 0), 2, 1)
        assert runner.predict_chunk(twice, "go to the chair").shape == (policies.CHUNK, 3)


@pytest.mark.parametrize(
    ("fault", "reason"),
    [
        ("raises", "policy_error"),
        ("nan", "policy_error"),
        ("shape", "policy_error"),
        ("hangs", "starved"),
    ],
)
def test_a_fault_of_the_policy_stops_the_robot_and_is_named(tmp_path: Path, fault: str, reason: str) -> None:
    runner = runner_of(tmp_path)
    predict, calls, forever = runner.predict_chunk, [0], threading.Event()

    def faulty(*args: Any, **options: Any) -> Any:
        calls[0] += 1
        if calls[0] < 4:
            return predict(*args, **options)
        if fault == "raises":
            raise RuntimeError("broken")
        if fault == "hangs":
            forever.wait(20)
        return np.full((policies.CHUNK, 3), np.nan) if fault == "nan" else np.zeros((2, 3))

    runner.predict_chunk = faulty  # type: ignore[method-assign]
    result, _ = asyncio.run(drive(runner))
    forever.set()
    assert result.reason == reason
    assert result.detail


def test_stop_emergency_stop_and_cancellation_end_a_run(tmp_path: Path) -> None:
    runner = runner_of(tmp_path)

    async def ended_by(act: str) -> str:
        async with Robot(image_size=SIZE) as robot:
            task = asyncio.ensure_future(runner.run(robot, "go to the chair"))
            await robot.sleep(1.0)
            if act == "cancel":
                task.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await task
                await robot.sleep(1.0)
                reason = "cancelled"
            else:
                getattr(robot, act)()
                reason = (await task).reason
            await robot.sleep(0.3)
            assert abs(robot._runtime.commanded().vx) == 0.0
            if act == "emergency_stop":
                with pytest.raises(EmergencyStopError):
                    await runner.run(robot, "go to the chair")
            return reason

    assert asyncio.run(ended_by("stop")) == "cancelled"
    assert asyncio.run(ended_by("cancel")) == "cancelled"
    assert asyncio.run(ended_by("emergency_stop")) == "estop"


def test_one_policy_at_a_time_drives_a_robot(tmp_path: Path) -> None:
    runner = runner_of(tmp_path)

    async def both() -> None:
        async with Robot(image_size=SIZE) as robot:
            first = asyncio.ensure_future(runner.run(robot, "go to the chair", timeout=1.0))
            await robot.sleep(0.2)
            with pytest.raises(SafetyError, match="another policy"):
                await runner.run(robot, "go to the door")
            assert (await first).reason == "timeout"
            motion = asyncio.ensure_future(robot.move_to(1.0, 0.0))
            await robot.sleep(0.2)
            with pytest.raises(SafetyError):
                await runner.run(robot, "go to the door")
            assert (await motion).success

    asyncio.run(both())


def test_what_does_not_fit_is_refused_with_both_sides(tmp_path: Path) -> None:
    runner = runner_of(tmp_path)
    right = np.zeros((*SIZE, 3), np.uint8)
    wrong: list[tuple[Any, str, str]] = [
        (right.astype(np.float32), "go", r"image must be \(H, W, 3\) uint8, BGR, got float32"),
        (right[:, :, 0], "go", "image must be"),
        (np.zeros((0, 0, 3), np.uint8), "go", "0 x 0 is no whole multiple of 12 x 16"),
        (np.zeros((24, 16, 3), np.uint8), "go", "24 x 16 is no whole multiple of 12 x 16"),
        ("picture", "go", "image must be"),
        (right, "", "instruction: this policy needs one"),
        (right, 3, "instruction must be a string"),
    ]
    for image, instruction, message in wrong:
        with pytest.raises(ContractError, match=message):
            runner.predict(image, instruction)

    async def on(hardware: str, size: tuple[int, int] | None) -> None:
        async with Robot(hardware=hardware, image_size=size) as robot:
            await runner.run(robot, "go to the chair")

    with pytest.raises(ContractError, match="the policy drives a holonomic base; turtlebot_like is differential"):
        asyncio.run(on("turtlebot_like", None))
    with pytest.raises(ContractError, match="100 x 100 is no whole multiple of 12 x 16"):
        asyncio.run(on("3we_standard_v2", (100, 100)))
    runner.policy = replace(runner.policy, kinematics=Kinematics.differential)
    with pytest.raises(HardwareError, match="turtlebot_like has no camera"):
        asyncio.run(on("turtlebot_like", None))


def test_in_real_time_actions_are_applied_when_they_arrive(tmp_path: Path) -> None:
    runner = runner_of(tmp_path)
    predict, forever, calls = runner.predict_chunk, threading.Event(), [0]

    def hanging(*args: Any, **options: Any) -> Any:
        calls[0] += 1
        if calls[0] == 4:
            forever.wait(20)
        return predict(*args, **options)

    async def drive_in_real_time() -> PolicyResult:
        async with Robot(image_size=SIZE, realtime=True) as robot:
            driven = await runner.run(robot, "go to the chair", timeout=1.0)
            assert (driven.reason, driven.inferences > 2) == ("timeout", True)
            calls[0] = 0
            runner.predict_chunk = hanging  # type: ignore[method-assign]
            return await runner.run(robot, "go to the chair", timeout=20.0)

    result = asyncio.run(drive_in_real_time())
    forever.set()
    assert (result.reason, result.inferences) == ("starved", 3)


def test_a_graph_that_onnxruntime_does_not_take_is_one_error(tmp_path: Path) -> None:
    model = policies.graph()
    model.opset_import[0].version = 10_000
    folder = policies.write(tmp_path / "policy", model)
    with pytest.raises(ConfigError, match=r"model\.onnx: "):
        VLARunner.from_pretrained(folder)
    model = policies.graph()
    model.ir_version = 10_000
    with pytest.raises(ConfigError, match=r"model\.onnx: onnxruntime does not take it: .*IR version"):
        VLARunner.from_pretrained(policies.write(tmp_path / "newer", model))
