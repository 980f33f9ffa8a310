"""A policy drives a robot, and stops it, whatever becomes of the policy."""

from __future__ import annotations

import asyncio
import sys
import threading
from dataclasses import replace
from itertools import groupby, pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from ai import policies
from threewe import (
    ConfigError,
    ContractError,
    EmergencyStopError,
    HardwareError,
    Kinematics,
    Robot,
    SafetyError,
    TimeoutError,
    Velocity,
    Zone,
    _core,
)
from threewe._core import Inference
from threewe.ai import PolicyResult, VLARunner
from threewe.ai.engine import GraphEngine
from threewe.ai.folder import EMBEDDED
from threewe.cli import app
from typer.testing import CliRunner

from verify.cases import act_checkpoints

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


def test_the_command_drives_and_its_exit_status_is_how_it_ended(tmp_path: Path) -> None:
    def run(name: str, velocity: tuple[float, float, float]) -> tuple[int, str]:
        folder = policies.write(tmp_path / name, policies.graph(velocity))
        how = ("--instruction", "go to the chair", "--scene", "apartment_v1", "--seconds", "2")
        done = CliRunner().invoke(app, ["policy", "run", str(folder), *how])
        assert done.exception is None or isinstance(done.exception, SystemExit)
        return done.exit_code, done.output

    status, said = run("stands", (0.0, 0.0, 0.0))
    assert (status, said.partition(":")[0]) == (0, "reached"), said
    status, said = run("drives", (0.2, 0.0, 0.0))
    assert (status, said.partition(",")[0]) == (1, "timeout"), said
    assert "2.0 robot s, 0.1 s of them without actions, " in said


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


def test_actions_that_run_out_for_less_than_a_second_are_counted(tmp_path: Path) -> None:
    """Chunks of three actions that arrive as the last of them is due: the timeline is empty for most of each 0.1 s."""
    runner = VLARunner.from_pretrained(policies.write(tmp_path / "policy", policies.graph(chunk=3), chunk=3))
    result, commands = asyncio.run(drive(runner))
    assert (result.reason, result.late) == ("timeout", 0)
    assert result.guided == pytest.approx(19 * 0.04)
    assert sum(a[0] > b[0] for a, b in pairwise(commands[:100])) > 40  # it brakes in between
    steady, _ = asyncio.run(drive(runner_of(tmp_path)))
    assert steady.guided == pytest.approx(2.0 - 0.1)  # all but the wait for the first ones


@pytest.mark.parametrize("latency", [0.0, 0.1, 0.2, 0.5])
def test_a_latency_shorter_than_the_chunk_leaves_no_gap_between_chunks(tmp_path: Path, latency: float) -> None:
    result, commands = asyncio.run(drive(runner_of(tmp_path, latency=latency), timeout=4.0))
    begun = next(i for i, v in enumerate(commands) if v[0] > 0)
    assert min(v[0] for v in commands[begun + 10 : 199]) == pytest.approx(0.2, abs=1e-6)
    assert (result.late, result.jumps) == (0, 1)  # it starts at once


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
        for image in (red, twice):
            started = runner._start(image, "go to the chair", Velocity(), [])  # as a run does
            assert isinstance(started, Inference)
            assert started.wait(60.0)
            assert runner._actions(started.result())[0] == pytest.approx([ahead, 0.0, 0.0])


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
    infer, calls, forever = runner._engine.infer, [0], threading.Event()

    def faulty(*args: Any) -> Any:
        calls[0] += 1
        if calls[0] < 4:
            return infer(*args)
        if fault == "raises":
            raise RuntimeError("broken")
        if fault == "hangs":
            forever.wait(20)
        return np.full((1, policies.CHUNK, 3), np.nan) if fault == "nan" else np.zeros((1, 2, 3))

    runner._engine = SimpleNamespace(infer=faulty)  # type: ignore[assignment]
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
            with pytest.raises(SafetyError, match="a motion owns"):
                await runner.run(robot, "go to the door")
            with pytest.raises(SafetyError, match="a motion owns"):
                robot.set_velocity(0.1, 0.0, 0.0)
            assert (await first).reason == "timeout"
            motion = asyncio.ensure_future(robot.move_to(1.0, 0.0))
            await robot.sleep(0.2)
            with pytest.raises(SafetyError):
                await runner.run(robot, "go to the door")
            assert (await motion).success

    asyncio.run(both())


def test_zones_keep_a_policy_out(tmp_path: Path) -> None:
    runner = runner_of(tmp_path)

    async def meets(limit: float | None) -> tuple[float, float]:
        """How far it comes [m], and how fast it is in the end [m/s]."""
        async with Robot(image_size=SIZE) as robot:
            robot.set_zones([Zone([(0.5, -1.0), (0.7, -1.0), (0.7, 1.0), (0.5, 1.0)], speed_limit=limit)])
            result = await runner.run(robot, "go to the chair", timeout=4.0)
            assert result.reason == "timeout"
            return robot.get_pose().x, robot.get_velocity().vx

    assert asyncio.run(meets(None)) == (pytest.approx(0.3, abs=0.1), pytest.approx(0.0, abs=0.02))
    x, vx = asyncio.run(meets(0.05))
    assert 0.3 < x < 0.6
    assert vx == pytest.approx(0.05, abs=0.02)


def test_a_robot_that_the_gate_stops_moves_away_from_what_is_near(tmp_path: Path) -> None:
    """A policy that wants to go on, whatever is in its way, and would stand there for ever."""
    runner = runner_of(tmp_path, (0.3, 0.0, 0.0))

    async def against_a_wall() -> tuple[PolicyResult, list[float]]:
        ahead: list[float] = []
        async with Robot(image_size=SIZE, localization="truth") as robot:
            robot.observe(lambda tick: ahead.append(tick.commanded.vx))
            return await runner.run(robot, "go to the chair", timeout=30.0), ahead

    result, ahead = asyncio.run(against_a_wall())
    assert result.reason == "timeout"
    assert 4 <= result.recoveries <= 20
    backwards = [vx < -0.1 for vx in ahead]
    assert sum(backwards) > 4 * 20  # ticks
    first = backwards.index(True)
    assert max(len(list(run)) for stands, run in groupby(vx == 0.0 for vx in ahead[first:]) if stands) < 60


def test_a_robot_that_is_lost_ends_a_run(tmp_path: Path) -> None:
    runner = runner_of(tmp_path, (0.1, 0.0, 0.5))

    async def kidnapped() -> PolicyResult:
        async with Robot(image_size=SIZE) as robot:
            run = asyncio.ensure_future(runner.run(robot, "go to the chair", timeout=60.0))
            await robot.sleep(2.0)
            assert robot.simulation is not None
            robot.simulation.teleport(robot.simulation.sample_free_pose(4))
            return await run

    result = asyncio.run(kidnapped())
    assert result.reason == "lost"


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


def test_a_run_that_is_refused_leaves_the_robot_still(tmp_path: Path) -> None:
    runner = runner_of(tmp_path)
    shape = act_checkpoints.Shape(*SIZE, state=0, text=False)
    deaf = VLARunner.from_pretrained(
        act_checkpoints.write(tmp_path / "act", shape), rate=10, rename={"action": ["vx", "vy", "omega"]}
    )
    right = np.zeros((*SIZE, 3), np.uint8)
    with pytest.raises(ContractError, match="instruction: this policy reads none, got 'go to the chair'; leave it out"):
        deaf.predict(right, "go to the chair")
    assert deaf.predict(right).shape == (3,)

    async def refused(runner: VLARunner, instruction: str, hardware: str, size: tuple[int, int] | None) -> str:
        commands: list[Velocity] = []
        async with Robot(hardware=hardware, image_size=size) as robot:
            robot.observe(lambda tick: commands.append(tick.commanded))
            await robot.sleep(0.5)
            with pytest.raises(ContractError) as refusal:
                await runner.run(robot, instruction)
            await robot.sleep(0.5)
            assert not any(map(any, commands))
            assert (await robot.move_forward(0.1)).success  # and nothing owns it
        return str(refusal.value)

    cases: list[tuple[VLARunner, str, str, tuple[int, int] | None, str]] = [
        (deaf, "go to the chair", "3we_standard_v2", SIZE, "this policy reads none"),
        (runner, "", "3we_standard_v2", SIZE, "this policy needs one"),
        (runner, "go to the chair", "3we_standard_v2", (100, 100), "no whole multiple of 12 x 16"),
        (runner, "go to the chair", "turtlebot_like", None, "turtlebot_like is differential"),
    ]
    for given, instruction, hardware, size, message in cases:
        assert message in asyncio.run(refused(given, instruction, hardware, size))


def test_in_real_time_actions_are_applied_when_they_arrive(tmp_path: Path) -> None:
    runner = runner_of(tmp_path)
    infer, forever, calls = runner._engine.infer, threading.Event(), [0]

    def hanging(*args: Any) -> Any:
        calls[0] += 1
        if calls[0] == 4:
            forever.wait(20)
        return infer(*args)

    async def drive_in_real_time() -> PolicyResult:
        async with Robot(image_size=SIZE, realtime=True) as robot:
            driven = await runner.run(robot, "go to the chair", timeout=1.0)
            assert (driven.reason, driven.inferences > 2) == ("timeout", True)
            calls[0] = 0
            runner._engine = SimpleNamespace(infer=hanging)  # type: ignore[assignment]
            return await runner.run(robot, "go to the chair", timeout=20.0)

    result = asyncio.run(drive_in_real_time())
    forever.set()
    assert (result.reason, result.inferences) == ("starved", 3)
    assert 1.0 < result.duration - result.guided < result.duration  # it braked for a second before it gave up


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


def test_the_library_runs_as_its_own_python_does_to_the_bit() -> None:
    import onnxruntime

    runner = VLARunner.from_pretrained("goto_v1")
    session = onnxruntime.InferenceSession(runner.policy.graph, providers=["CPUExecutionProvider"])
    random = np.random.default_rng(1)
    for factor in (1, 2, 3, 8):
        image = random.integers(0, 256, (60 * factor, 80 * factor, 3), np.uint8)
        feed = runner._feed(image, "go to the chair", None)
        means = image.reshape(60, factor, 80, factor, 3).mean((1, 3), dtype=np.float32) / 255
        np.testing.assert_array_equal(feed["observation.images.camera"][0], means[:, :, ::-1].transpose(2, 0, 1))
        (expected,) = session.run(["action"], feed)
        np.testing.assert_array_equal(runner._engine.infer(feed, ""), expected)
        started = runner._start(image, "go to the chair", Velocity(), [])
        assert isinstance(started, Inference)
        assert started.wait(60.0)
        np.testing.assert_array_equal(started.result(), expected)


def test_an_inference_that_is_dropped_is_not_waited_for(tmp_path: Path) -> None:
    shape = act_checkpoints.Shape(480, 640, state=0, text=False)
    folder = act_checkpoints.write(tmp_path / "act", shape)
    runner = VLARunner.from_pretrained(folder, rate=10, rename={"action": ["vx", "vy", "omega"]})
    image = np.zeros((480, 640, 3), np.uint8)
    kept = runner._start(image, "", Velocity(), [])
    for _ in range(5):
        runner._start(image, "", Velocity(), [])
    assert not kept.done()  # one takes far longer than to start and to drop others
    with pytest.raises(TimeoutError, match="not done"):
        kept.result()
    assert isinstance(kept, Inference)
    assert kept.wait(300.0)


def test_a_missing_or_wrong_library_is_one_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = policies.write(tmp_path / "policy")
    for library, message in (
        (tmp_path / "none.so", r"model\.onnx: .*onnxruntime: .*none\.so: cannot open"),
        (Path(_core.__file__), r"_core.*: not onnxruntime: no OrtGetApiBase"),
    ):
        monkeypatch.setenv("THREEWE_ONNXRUNTIME", str(library))
        with pytest.raises(ConfigError, match=message):
            VLARunner.from_pretrained(folder)
    monkeypatch.delenv("THREEWE_ONNXRUNTIME")
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    with pytest.raises(ConfigError, match=r'running a policy: .*pip install "threewe\[policy\]"'):
        VLARunner.from_pretrained(folder)


def test_inputs_that_do_not_fit_the_graph_are_refused() -> None:
    runner = VLARunner.from_pretrained("goto_v1")
    engine = runner._engine
    assert isinstance(engine, GraphEngine)
    text = np.zeros((1, 64), np.float32)
    with pytest.raises(ContractError, match=r"input 'observation.environment_state' has 64 numbers, got 3"):
        engine.infer({"observation.images.camera": np.zeros((1, 3, 60, 80), np.float32), EMBEDDED: text[:, :3]}, "")
    with pytest.raises(ContractError, match="the graph takes 2 inputs, got 1"):
        engine._session.run([text])
    with pytest.raises(ContractError, match="61 x 80 is no whole multiple of 60 x 80"):
        engine._session.start([(np.zeros((61, 80, 3), np.uint8), 60, 80, True), text])


@pytest.mark.parametrize("latency", [0.1, 0.2])
def test_committed_actions_go_in_with_the_picture_and_seams_shrink(tmp_path: Path, latency: float) -> None:
    """A policy whose speed follows the picture, while the robot turns: each chunk differs from the one before."""
    jumps = []
    for prefix in (0, 8):
        graph = policies.graph((0.0, 0.0, 0.8), red=0.8, prefix=prefix)
        changes = {"merge": "replace", "latency": latency, **({"prefix": prefix} if prefix else {})}
        folder = tmp_path / str(prefix)
        folder.mkdir()
        runner = VLARunner.from_pretrained(policies.write(folder / "policy", graph, **changes))
        result, commands = asyncio.run(drive(runner, timeout=4.0))
        speeds = np.array([velocity[0] for velocity in commands])[60:195]
        assert speeds.std() > 0.005
        jumps.append(np.abs(np.diff(speeds)).max())
        assert result.reason == "timeout"
    assert jumps[1] < 0.5 * jumps[0]  # what was one step is spread over the time between two actions


def test_a_prefix_is_what_the_timeline_did_and_will_do(tmp_path: Path) -> None:
    given: list[np.ndarray[Any, Any]] = []
    changes = {"merge": "replace", "prefix": 6}
    runner = VLARunner.from_pretrained(policies.write(tmp_path / "policy", policies.graph(prefix=6), **changes))
    infer = runner._engine.infer

    def watched(feed: Any, instruction: str) -> Any:
        given.append(feed["action.prefix"][0])
        return infer(feed, instruction)

    runner._engine = SimpleNamespace(infer=watched)  # type: ignore[assignment]
    asyncio.run(drive(runner))
    assert not given[0].any()  # nothing has been wanted yet
    for each in given[8:]:
        count = int(each[:, 3].sum())
        assert 2 <= count <= 4  # of a picture up to 0.2 s old, until 0.1 s from now
        assert each[:count] == pytest.approx(np.tile([0.2, 0.0, 0.0, 1.0], (count, 1)), abs=1e-6)
        assert not each[count:].any()


def test_a_prefix_that_leaves_nothing_is_refused(tmp_path: Path) -> None:
    folder = policies.write(tmp_path / "policy", policies.graph(prefix=10), prefix=10)
    with pytest.raises(ConfigError, match=r"policy\.json: prefix: 10 actions leave none of a chunk of 10"):
        VLARunner.from_pretrained(folder)
    folder = policies.write(tmp_path / "other", policies.graph(), prefix=3)
    with pytest.raises(ConfigError, match=r"inputs do not fit policy\.json: .*action\.prefix \(1x3x4\)"):
        VLARunner.from_pretrained(folder)
