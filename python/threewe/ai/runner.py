"""Runner of learned policies: pictures go in off the control thread, actions come out in robot time."""

from __future__ import annotations

import asyncio
import math
import os
import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from threewe._arguments import as_seconds, as_text
from threewe._core import ActionTimeline, Inference, Reason, Velocity, instruction_embedding
from threewe._core import network_input as picture_input
from threewe.ai.engine import Engine, GraphEngine
from threewe.ai.folder import (
    CAMERA,
    EMBEDDED,
    EMBEDDING,
    PREFIX,
    STATE,
    CameraInput,
    Policy,
    Quantity,
    image_input,
)
from threewe.ai.loading import engine_of, open_policy
from threewe.ai.naming import Rename
from threewe.ai.recovery import Recovery
from threewe.errors import ContractError, HardwareError
from threewe.language import encodable

if TYPE_CHECKING:
    from threewe.robot import Robot

Images: TypeAlias = NDArray[np.uint8] | Mapping[str, NDArray[np.uint8]]

TICK = 0.02
"""[s] one control period"""
STANDS = (0.02, 0.05)
"""[m/s], [rad/s] below which a policy counts as standing still"""
STILL = 0.5
"""[s] of standing still that count as having reached the goal"""
PATIENCE = 1.0
"""[s] that a policy may be silent beyond the end of its timeline"""
WALL_PATIENCE = 5.0
"""[s] of wall time that a world in lockstep stands still for one inference: machines have other things to do, too"""
MOST = 3
"""Inferences at a time"""
REMEMBERED = 100
"""Ticks whose velocities may be committed to a chunk of an older picture"""
AGE = 0.2
"""[s] of a picture whose inference begins, at most"""


@dataclass(frozen=True)
class PolicyResult:
    """What became of a run."""

    success: bool
    """`reason` is `reached`: the policy stood still for 0.5 s; whether it is where it should be it does not know"""
    reason: str
    """reached, timeout, cancelled, estop, lost, fault, starved or policy_error"""
    detail: str
    """says more; may be empty"""
    duration: float
    """[s] of robot time"""
    guided: float
    """[s] of these for which there were actions; else it waited for the first ones, or braked as they had run out"""
    inferences: int
    """chunks of actions that were applied"""
    late: int
    """chunks that arrived after their end, and were dropped"""
    recoveries: int
    """times that the gate had stopped the robot for what is in the way, and it moved a little away from that"""
    jumps: int
    """chunks that changed the velocity by more than a control period's acceleration"""


class VLARunner:
    """Drives a robot by a learned policy. Make it with `from_pretrained`."""

    def __init__(self, policy: Policy, engine: Engine | None = None) -> None:
        """Runs a policy that was read by `read_policy`, by its graph unless an engine is given."""
        self._engine = engine or engine_of(policy, policy.graph.read_bytes())
        self.policy = policy

    @classmethod
    def from_pretrained(
        cls,
        folder: str | os.PathLike[str],
        *,
        rename: Rename | None = None,
        rate: float | None = None,
        dataset: str | os.PathLike[str] | None = None,
        python: str | os.PathLike[str] | None = None,
        revision: str | None = None,
    ) -> Self:
        """Loads a policy: ours, or a checkpoint of LeRobot's ACT. Needs the extra `policy`.

        LeRobot's say neither their rate nor what their numbers are; `dataset`, or `rate` and `rename`, do.

        Args:
            folder: with `policy.json` or LeRobot's `config.json`; the name of one that ships, such as `goto_v1`;
                `user/name` of the Hugging Face Hub, which needs the extra `data`; or `ws://host:port`, a policy's
                server.
            rename: by the policy's name, the robot's: `{"front": "camera", "action": ["vx", "vy", "omega"]}`.
            rate: [Hz] of the actions of a checkpoint.
            dataset: folder of the LeRobot dataset that a checkpoint was trained on, which has names and rate.
            python: the interpreter of LeRobot's own environment, to run a checkpoint there, of whatever kind.
            revision: of a policy of the Hub: branch, tag or commit; `main` where left out.

        Raises:
            ConnectionError: no policy's server at that address, or no connection to the Hub.
            ConfigError: a folder that is not one, that holds what would run code, or whose names do not fit; with file
                and field.
        """
        return cls(*open_policy(folder, rename, rate, dataset, python, revision))

    def predict(self, image: Images, instruction: str = "", *, velocity: Velocity | None = None) -> NDArray[np.float64]:
        """The action of now: (3,) [m/s, m/s, rad/s]. See `predict_chunk`."""
        action: NDArray[np.float64] = self.predict_chunk(image, instruction, velocity=velocity)[0]
        return action

    def predict_chunk(
        self, image: Images, instruction: str = "", *, velocity: Velocity | None = None
    ) -> NDArray[np.float64]:
        """The actions from now on, `policy.rate` a second: (chunk, 3) [m/s, m/s, rad/s].

        Args:
            image: (H, W, 3) uint8, BGR, of the policy's size or a whole multiple of it; by name for several cameras.
            instruction: for a policy that reads them.
            velocity: of the robot, for a policy that takes it.

        Raises:
            ContractError: an image of another type or size, an instruction for a policy without language, none for one
                with it, or a missing velocity.
        """
        return self._actions(self._engine.infer(self._feed(image, instruction, velocity), instruction))

    def _feed(
        self, image: Images, instruction: str, velocity: Velocity | None, committed: Sequence[Velocity] = ()
    ) -> dict[str, NDArray[np.float32]]:
        """What the policy's network takes. Raises ContractError."""
        pictures = {image_input(camera.name): network_input(each, camera) for camera, each in self._images(image)}
        return {**pictures, **self._numbers(instruction, velocity, committed)}

    def _numbers(
        self, instruction: str, velocity: Velocity | None, committed: Sequence[Velocity]
    ) -> dict[str, NDArray[np.float32]]:
        """What it takes that is no picture. Raises ContractError."""
        feed = {}
        if (embedding := self._embedding(instruction)) is not None:
            feed[EMBEDDED] = embedding
        if self.policy.state:
            if velocity is None:
                names = ", ".join(each.name for each in self.policy.state)
                raise ContractError(f"velocity: this policy takes {names}; pass velocity=robot.get_velocity()")
            feed[STATE] = np.array([_normalised(velocity, self.policy.state)], np.float32)
        if self.policy.prefix:
            feed[PREFIX] = np.zeros(self.policy.inputs()[PREFIX], np.float32)
            for k, each in enumerate(committed):
                feed[PREFIX][0, k] = [*_normalised(each, self.policy.action), 1.0]
        return feed

    def _start(self, image: Images, instruction: str, velocity: Velocity, committed: Sequence[Velocity]) -> _Thinking:
        """Computes the network's output off this thread: in C++ where it can. Raises ContractError."""
        if isinstance(self._engine, GraphEngine):
            return self._engine.start(self._images(image), self._numbers(instruction, velocity, committed))
        engine = self._engine
        return _in_thread(lambda: engine.infer(self._feed(image, instruction, velocity, committed), instruction))

    async def run(self, robot: Robot, instruction: str = "", *, timeout: float = 60.0) -> PolicyResult:
        """Drives a robot until the policy stands still, or `timeout` [s] of robot time are over.

        It is a motion as `move_to` is one: it owns the robot, every command passes the safety gate, zones slow it down
        or keep it out, and `robot.stop()` ends it as `cancelled`, as cancelling the task does.

        Raises:
            ContractError: an instruction that does not fit the policy, or kinematics or an image size that do not.
            HardwareError: the robot has no camera.
            EmergencyStopError: the emergency stop is latched.
            SafetyError: another policy or motion drives this robot.
        """
        limit = as_seconds("timeout", timeout)
        self._embedding(instruction)
        self._check_robot(robot)
        return await _Run(self, robot, instruction).drive(limit)

    def _check_robot(self, robot: Robot) -> None:
        mine, its = self.policy.kinematics, robot.features.kinematics
        if mine != its:
            raise ContractError(f"kinematics: the policy drives a {mine.name} base; {robot.profile.name} is {its.name}")
        if robot.profile.camera is None:
            raise HardwareError(f"{robot.profile.name} has no camera; the policy needs 'camera'")
        names = [camera.name for camera in self.policy.cameras]
        if names != [CAMERA]:
            fix = (
                f': from_pretrained(..., rename={{"{names[0]}": "{CAMERA}"}}) if it is the same'
                if len(names) == 1
                else ""
            )
            raise ContractError(f"cameras: the policy takes {', '.join(names)}; {robot.profile.name} has {CAMERA}{fix}")
        _factor((robot.get_image()).shape, self.policy.cameras[0])

    def _images(self, image: Images) -> list[tuple[CameraInput, NDArray[np.uint8]]]:
        cameras = self.policy.cameras
        names = [camera.name for camera in cameras]
        if isinstance(image, Mapping):
            if set(image) != set(names):
                raise ContractError(
                    f"image: pictures of {', '.join(map(str, image))}; the policy takes {', '.join(names)}"
                )
            return [(camera, image[camera.name]) for camera in cameras]
        if len(cameras) > 1:
            raise ContractError(
                f"image: one picture; the policy takes {', '.join(names)}: pass them by name, in a mapping"
            )
        return [(cameras[0], image)]

    def _embedding(self, instruction: str) -> NDArray[np.float32] | None:
        text = encodable(as_text("instruction", instruction))
        if self.policy.language and not text.strip():
            raise ContractError("instruction: this policy needs one, such as 'go to the chair'")
        if not self.policy.language and text:
            raise ContractError(f"instruction: this policy reads none, got {text[:60]!r}; leave it out")
        if not self.policy.language:
            return None
        return np.array(instruction_embedding(text), np.float32).reshape(1, EMBEDDING)

    def _actions(self, output: NDArray[np.float32], committed: Sequence[Velocity] = ()) -> NDArray[np.float64]:
        """(chunk, 3), which begins with what was committed."""
        actions = np.zeros((self.policy.chunk, 3))
        for i, quantity in enumerate(self.policy.action):
            column = output[0, :, i].astype(np.float64) * quantity.std + quantity.mean
            actions[:, ("vx", "vy", "omega").index(quantity.name)] = column * quantity.scale
        for k, each in enumerate(committed):
            actions[k] = tuple(each)
        return actions


def _normalised(velocity: Velocity, quantities: Sequence[Quantity]) -> list[float]:
    return [(getattr(velocity, q.name) / q.scale - q.mean) / q.std for q in quantities]


def _factor(shape: tuple[int, ...], camera: CameraInput) -> int:
    """How many times as large as the policy's a picture is, the same both ways. Raises ContractError."""
    height, width = shape[:2]
    factor = height // camera.height
    if factor < 1 or (factor * camera.height, factor * camera.width) != (height, width):
        raise ContractError(
            f"image: {height} x {width} is no whole multiple of {camera.height} x {camera.width}, which the policy "
            f"takes from '{camera.name}': use Robot(image_size=({camera.height}, {camera.width}))"
        )
    return factor


def network_input(image: NDArray[np.uint8], camera: CameraInput) -> NDArray[np.float32]:
    """(1, 3, H, W) 0 to 1 in the policy's order of colours, each pixel the mean of those that it stands for."""
    if not isinstance(image, np.ndarray) or image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3:
        found = f"{image.dtype} {image.shape}" if isinstance(image, np.ndarray) else type(image).__name__
        raise ContractError(f"image must be (H, W, 3) uint8, BGR, got {found}")
    _factor(image.shape, camera)
    return picture_input(np.ascontiguousarray(image), camera.height, camera.width, camera.color == "rgb")


def inferences_at_a_time(policy: Policy) -> int:
    """As few as leave no time without actions: one that has just begun is applied before the chunk before it ends."""
    spare = (policy.chunk - 1) / policy.rate - AGE - policy.latency
    return min(MOST, max(1, math.ceil(policy.latency / spare - 1e-9))) if spare > 0 else MOST


class _Run:
    """One run: a motion that a timeline steers, and inferences beside it, which are applied in their order."""

    def __init__(self, runner: VLARunner, robot: Robot, instruction: str) -> None:
        self.runner, self.robot, self.instruction = runner, robot, instruction
        policy = runner.policy
        limits = robot.profile.operating_limits
        self.timeline = ActionTimeline(limits, policy.rate, policy.chunk, policy.merge)
        self.recovery = Recovery(robot)
        self.lockstep = not robot._world.realtime
        self.latency = math.ceil(policy.latency / TICK - 1e-9)  # ticks
        self.most = inferences_at_a_time(policy)
        # ticks from one inference to the next, at least
        self.stride = max(1, round(1 / policy.rate / TICK), -(-self.latency // self.most))
        self.tick = 0
        self.begun = robot.now
        self.measured = -1.0  # of the newest picture that was taken
        self.pending: list[_Pending] = []
        self.willed: deque[tuple[float, Velocity]] = deque(maxlen=REMEMBERED)  # by the timeline, in the newest ticks
        self.since_begun = self.stride
        self.guided = 0  # ticks for which there were actions
        self.stands_since: float | None = None
        self.over: tuple[Reason, str] | None = None  # what ends the motion in the next tick

    async def drive(self, limit: float) -> PolicyResult:
        robot = self.robot
        motion = robot._runtime.drive(self._decide, limit)
        observer = robot.observe(self.recovery.see)
        try:
            while not motion.done:
                if self.over is None:
                    self._begin_inference()
                    await self._take_actions()
                await robot._time.wait(motion, robot._world.alarm(TICK))
                self.tick += 1
        finally:
            motion.cancel()
            robot.unobserve(observer)
        ended, counts = motion.result(), self.timeline
        for each in self.pending if ended.reason != Reason.starved else []:
            await _settled(each.thinking, PATIENCE)  # no thread of a run outlives it, but for one that hangs
        reason, detail = str(ended.reason), ended.detail
        guided = TICK * self.guided
        recoveries, jumps = self.recovery.count, counts.jumps
        return PolicyResult(
            ended.success, reason, detail, ended.duration, guided, counts.applied, counts.late, recoveries, jumps
        )

    def _decide(self, now: float) -> tuple[Velocity, Reason, str]:
        """What is wanted in the control period that begins, or why the motion is over."""
        if self.over is None:
            self.over = self._judged(now)
        if self.over is not None:
            return Velocity(), *self.over
        wanted = self.timeline.next(now)
        velocity = self.recovery.next(now, wanted)
        if (end := self.timeline.end) is not None:
            self.willed.append((now, velocity))
            self.guided += end >= now
        self._watch(wanted, now)
        return velocity, Reason.running, ""

    def _judged(self, now: float) -> tuple[Reason, str] | None:
        camera = self.robot.health["camera"]
        if not camera.ok:
            return Reason.fault, f"camera: {camera.detail or camera.fault}"
        if self.stands_since is not None and now - self.stands_since >= STILL - 1e-9:
            return Reason.reached, ""
        since = self.begun if self.timeline.end is None else self.timeline.end
        if now - max(since, self.begun) > PATIENCE + self.runner.policy.latency:
            return Reason.starved, f"no actions for {PATIENCE:g} s"
        return None

    def _begin_inference(self) -> None:
        """Starts the next inference, once there is a new picture and those on their way are far enough."""
        self.since_begun += 1
        measured = self.robot._runtime.image_measured()
        if len(self.pending) == self.most or measured <= self.measured or self.since_begun < self.stride:
            return
        image, velocity = self.robot.get_image(), self.robot.get_velocity()
        self.measured, self.since_begun = measured, 0
        committed = self._committed(measured)
        thinking = self.runner._start(image, self.instruction, velocity, committed)
        self.pending.append(_Pending(self.tick + self.latency, measured, committed, thinking))

    def _committed(self, measured: float) -> list[Velocity]:
        """The first actions of a chunk that begins now: until the next one is applied the timeline will not change."""
        now, period = self.robot.now, 1 / self.runner.policy.rate
        due = now + TICK * min([self.latency, *(each.due - self.tick for each in self.pending)])
        found: list[Velocity] = []
        for k in range(self.runner.policy.prefix):
            t = measured + k * period
            velocity = self._willed(t) if t <= now else self.timeline.planned(t)
            if velocity is None or t - period >= due:
                break
            found.append(velocity)
        return found

    def _willed(self, t: float) -> Velocity | None:
        return next((velocity for then, velocity in reversed(self.willed) if then <= t + 1e-9), None)

    async def _take_actions(self) -> None:
        """Adds the actions that have arrived to the timeline."""
        try:
            while self.pending and (chunk := await self._arrived(self.pending[0])) is not None:
                self.timeline.add(self.pending.pop(0).measured, chunk, self.robot.now)
        except TimeoutError:
            self.over = Reason.starved, f"no actions within {WALL_PATIENCE:g} s"
        except Exception as error:  # of whatever kind: the policy is not ours
            self.over = Reason.policy_error, f"{type(error).__name__}: {error}"

    async def _arrived(self, pending: _Pending) -> NDArray[np.float64] | None:
        """The actions that are due: in lockstep those of a fixed number of ticks before, else those that are there."""
        thinking = pending.thinking
        if not self.lockstep and not thinking.done():
            return None
        if self.lockstep:
            if self.tick < pending.due:
                return None
            if not thinking.done():
                async with self.robot.thinking(seconds=0.0):
                    await _settled(thinking, WALL_PATIENCE)
        if not thinking.done():
            raise TimeoutError
        return self.runner._actions(thinking.result(), pending.committed)

    def _watch(self, velocity: Velocity, now: float) -> None:
        """Since when the policy stands still of its own will."""
        end = self.timeline.end
        willed = end is not None and end >= now
        speed = math.hypot(velocity.vx, velocity.vy)
        if not willed or speed > STANDS[0] or abs(velocity.omega) > STANDS[1]:
            self.stands_since = None
        elif self.stands_since is None:
            self.stands_since = now


@dataclass(frozen=True)
class _Pending:
    """An inference that has begun."""

    due: int  # at a tick, in lockstep
    measured: float  # [s] when its picture was
    committed: list[Velocity]
    thinking: _Thinking


_Thinking: TypeAlias = Inference | Future[NDArray[np.float32]]
"""A network's output that is computed off the control thread: in C++, or by a policy that needs Python."""


async def _settled(thinking: _Thinking, patience: float) -> None:
    """Waits until there is a result or an error, for a while of wall time. Raises nothing."""
    if isinstance(thinking, Inference):
        await asyncio.to_thread(thinking.wait, patience)
        return
    waited = asyncio.wrap_future(thinking)
    await asyncio.wait([waited], timeout=patience)
    if waited.done():
        waited.exception()  # asyncio reports errors that are never read


def _in_thread(work: Callable[[], NDArray[np.float32]]) -> Future[NDArray[np.float32]]:
    """Runs in a thread that keeps no program from ending: what hangs cannot be stopped."""
    future: Future[NDArray[np.float32]] = Future()

    def run() -> None:
        try:
            future.set_result(work())
        except BaseException as error:
            future.set_exception(error)

    threading.Thread(target=run, name="policy", daemon=True).start()
    return future
