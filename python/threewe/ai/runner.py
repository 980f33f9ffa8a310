"""Runner of learned policies: pictures go in off the control thread, actions come out in robot time."""

from __future__ import annotations

import asyncio
import math
import os
import threading
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self
from weakref import WeakSet

import numpy as np
from numpy.typing import NDArray

from threewe._arguments import as_seconds, as_text
from threewe._core import ActionTimeline, Velocity, instruction_embedding
from threewe._extras import needed_for
from threewe.ai.folder import EMBEDDING, GRAPH, CameraInput, Policy, image_input, read_policy
from threewe.errors import ConfigError, ContractError, EmergencyStopError, HardwareError, SafetyError
from threewe.language import encodable

if TYPE_CHECKING:
    from threewe.robot import Robot

TICK = 0.02
"""[s] one control period"""
HOLD = 0.1
"""[s] that a command is held: a program that hangs stops the robot"""
STANDS = (0.02, 0.05)
"""[m/s], [rad/s] below which a policy counts as standing still"""
STILL = 0.5
"""[s] of standing still that count as having reached the goal"""
PATIENCE = 1.0
"""[s] that a policy may be silent beyond the end of its timeline; in lockstep, of wall time for one inference"""
LONGEST_STOP = 1.0
"""[s] that a robot is given to stand in the end"""

_driven: WeakSet[Robot] = WeakSet()  # by a policy, now


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
    inferences: int
    """chunks of actions that were applied"""
    late: int
    """chunks that arrived after their end, and were dropped"""
    jumps: int
    """chunks that changed the velocity by more than a control period's acceleration"""


class VLARunner:
    """Drives a robot by a learned policy. Make it with `from_pretrained`."""

    def __init__(self, policy: Policy) -> None:
        """Loads the graph of a policy that was read by `read_policy`."""
        with needed_for("running a policy", "policy"):
            import onnxruntime

        settings = onnxruntime.SessionOptions()
        settings.intra_op_num_threads = settings.inter_op_num_threads = 1
        settings.log_severity_level = 4
        graph = policy.folder / GRAPH
        content = graph.read_bytes()  # as bytes: what has no folder can name no other file
        try:
            self._session = onnxruntime.InferenceSession(content, settings, providers=["CPUExecutionProvider"])
        except Exception as error:  # onnxruntime has a type for each
            raise ConfigError(f"{graph}: onnxruntime does not take it: {str(error).splitlines()[0]}") from None
        self.policy = policy

    @classmethod
    def from_pretrained(cls, folder: str | os.PathLike[str]) -> Self:
        """Loads the folder of a policy; needs the extra `policy`.

        Raises:
            ConfigError: a folder that is not one, or that holds what would run code; with file and field.
        """
        return cls(read_policy(folder))

    def predict(
        self, image: NDArray[np.uint8], instruction: str = "", *, velocity: Velocity | None = None
    ) -> NDArray[np.float64]:
        """The action of now: (3,) [m/s, m/s, rad/s]. See `predict_chunk`."""
        action: NDArray[np.float64] = self.predict_chunk(image, instruction, velocity=velocity)[0]
        return action

    def predict_chunk(
        self, image: NDArray[np.uint8], instruction: str = "", *, velocity: Velocity | None = None
    ) -> NDArray[np.float64]:
        """The actions from now on, `policy.rate` a second: (chunk, 3) [m/s, m/s, rad/s].

        Args:
            image: (H, W, 3) uint8, BGR, of the policy's size or a whole multiple of it.
            instruction: for a policy that reads them.
            velocity: of the robot, for a policy that takes it.

        Raises:
            ContractError: an image of another type or size, an instruction for a policy without language, none for one
                with it, or a missing velocity.
        """
        camera = self.policy.cameras[0]
        feed = {image_input(camera.name): _pixels(image, camera)}
        if (embedding := self._embedding(instruction)) is not None:
            feed["observation.environment_state"] = embedding
        if self.policy.state:
            if velocity is None:
                names = ", ".join(each.name for each in self.policy.state)
                raise ContractError(f"velocity: this policy takes {names}; pass velocity=robot.get_velocity()")
            values = [(getattr(velocity, q.name) / q.scale - q.mean) / q.std for q in self.policy.state]
            feed["observation.state"] = np.array([values], np.float32)
        return self._actions(self._session.run(["action"], feed)[0])

    async def run(self, robot: Robot, instruction: str = "", *, timeout: float = 60.0) -> PolicyResult:
        """Drives a robot until the policy stands still, or `timeout` [s] of robot time are over.

        Every command passes the safety gate, as yours do. `robot.stop()` ends it as `cancelled`; cancelling the task
        stops the robot, too.

        Raises:
            ContractError: an instruction that does not fit the policy, or kinematics or an image size that do not.
            HardwareError: the robot has no camera.
            EmergencyStopError: the emergency stop is latched.
            SafetyError: another policy or motion drives this robot.
        """
        limit = as_seconds("timeout", timeout)
        self._embedding(instruction)
        self._check_robot(robot)
        if robot in _driven:
            raise SafetyError("another policy drives this robot: wait for it, or call robot.stop()")
        robot.set_velocity(0.0, 0.0, 0.0)  # refused where another motion owns the robot
        _driven.add(robot)
        try:
            return await _Run(self, robot, instruction, limit).drive()
        finally:
            _driven.discard(robot)
            if robot.connected:
                robot.stop()

    def _check_robot(self, robot: Robot) -> None:
        mine, its = self.policy.kinematics, robot.features.kinematics
        if mine != its:
            raise ContractError(f"kinematics: the policy drives a {mine.name} base; {robot.profile.name} is {its.name}")
        if robot.profile.camera is None:
            raise HardwareError(f"{robot.profile.name} has no camera; the policy needs 'camera'")
        _factor((robot.get_image()).shape, self.policy.cameras[0])

    def _embedding(self, instruction: str) -> NDArray[np.float32] | None:
        text = encodable(as_text("instruction", instruction))
        if self.policy.language and not text.strip():
            raise ContractError("instruction: this policy needs one, such as 'go to the chair'")
        if not self.policy.language and text:
            raise ContractError(f"instruction: this policy reads none, got {text[:60]!r}; leave it out")
        if not self.policy.language:
            return None
        return np.array(instruction_embedding(text), np.float32).reshape(1, EMBEDDING)

    def _actions(self, output: NDArray[np.float32]) -> NDArray[np.float64]:
        actions = np.zeros((self.policy.chunk, 3))
        for i, quantity in enumerate(self.policy.action):
            column = output[0, :, i].astype(np.float64) * quantity.std + quantity.mean
            actions[:, ("vx", "vy", "omega").index(quantity.name)] = column * quantity.scale
        return actions


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


def _pixels(image: NDArray[np.uint8], camera: CameraInput) -> NDArray[np.float32]:
    """(1, 3, H, W) 0 to 1 in the policy's order of colours, each pixel the mean of those that it stands for."""
    if not isinstance(image, np.ndarray) or image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3:
        found = f"{image.dtype} {image.shape}" if isinstance(image, np.ndarray) else type(image).__name__
        raise ContractError(f"image must be (H, W, 3) uint8, BGR, got {found}")
    n = _factor(image.shape, camera)
    means = image.reshape(camera.height, n, camera.width, n, 3).mean((1, 3), dtype=np.float32) / 255
    ordered = means[:, :, ::-1] if camera.color == "rgb" else means
    return np.ascontiguousarray(ordered.transpose(2, 0, 1)[None], np.float32)


class _Run:
    """One run: a control loop of ticks, and at most one inference beside it."""

    def __init__(self, runner: VLARunner, robot: Robot, instruction: str, limit: float) -> None:
        self.runner, self.robot, self.instruction, self.limit = runner, robot, instruction, limit
        policy = runner.policy
        limits = robot.profile.operating_limits
        self.timeline = ActionTimeline(limits, policy.rate, policy.chunk, policy.merge)
        self.lockstep = not robot._world.realtime
        self.latency = math.ceil(policy.latency / TICK - 1e-9)  # ticks
        self.stride = max(1, round(1 / policy.rate / TICK))  # ticks from one inference to the next, at least
        self.tick = 0
        self.begun = robot.now
        self.stops = robot._stops
        self.measured = -1.0  # of the newest picture that was taken
        self.pending: tuple[int, float, Future[NDArray[np.float64]]] | None = None
        self.since_begun = self.stride
        self.stands_since: float | None = None

    async def drive(self) -> PolicyResult:
        reason, detail = await self._until_it_ends()
        duration = self.robot.now - self.begun
        if self.robot.connected:
            if self.robot._stops == self.stops:
                self.robot.stop()
            await self._stand()
        if self.pending is not None and reason != "starved":  # no thread of a run outlives it, but for one that hangs
            await _settled(self.pending[2])
        counts = self.timeline
        return PolicyResult(reason == "reached", reason, detail, duration, counts.applied, counts.late, counts.jumps)

    async def _until_it_ends(self) -> tuple[str, str]:
        while True:
            if ended := self._ended():
                return ended
            self._begin_inference()
            try:
                if self.pending is not None and (chunk := await self._arrived()) is not None:
                    self.timeline.add(self.pending[1], chunk, self.robot.now)
                    self.pending = None
            except TimeoutError:
                return "starved", f"no actions within {PATIENCE:g} s"
            except Exception as error:  # of whatever kind: the policy is not ours
                return "policy_error", f"{type(error).__name__}: {error}"
            velocity = self.timeline.next(self.robot.now)
            self._watch(velocity)
            try:
                self.robot.set_velocity(velocity.vx, velocity.vy, velocity.omega, hold=HOLD)
            except EmergencyStopError:
                return "estop", ""
            except SafetyError as error:
                return "cancelled", str(error)
            await self.robot.sleep(TICK)
            self.tick += 1

    def _ended(self) -> tuple[str, str] | None:
        robot, now = self.robot, self.robot.now
        if not robot.connected or robot._stops != self.stops:
            return "cancelled", ""
        if robot.emergency_stopped:
            return "estop", ""
        if robot._runtime.fault:
            return "fault", str(robot._runtime.fault)
        if not robot.health["camera"].ok:
            return "fault", f"camera: {robot.health['camera'].detail or robot.health['camera'].fault}"
        if robot.lost:
            return "lost", ""
        if self.stands_since is not None and now - self.stands_since >= STILL - 1e-9:
            return "reached", ""
        if now - self.begun >= self.limit - 1e-9:
            return "timeout", f"{self.limit:g} s of robot time were not enough"
        since = self.begun if self.timeline.end is None else self.timeline.end
        if now - max(since, self.begun) > PATIENCE + self.runner.policy.latency:
            return "starved", f"no actions for {PATIENCE:g} s"
        return None

    def _begin_inference(self) -> None:
        """Starts the next inference, once there is a new picture and none is on its way."""
        self.since_begun += 1
        measured = self.robot._runtime.image_measured()
        if self.pending is not None or measured <= self.measured or self.since_begun < self.stride:
            return
        image, velocity = self.robot.get_image(), self.robot.get_velocity()
        self.measured, self.since_begun = measured, 0
        future = _in_thread(lambda: self.runner.predict_chunk(image, self.instruction, velocity=velocity))
        self.pending = self.tick + self.latency, measured, future

    async def _arrived(self) -> NDArray[np.float64] | None:
        """The actions that are due: in lockstep those of a fixed number of ticks before, else those that are there."""
        assert self.pending is not None
        due, _, future = self.pending
        if not self.lockstep:
            return future.result() if future.done() else None
        if self.tick < due:
            return None
        if not future.done():
            async with self.robot.thinking(seconds=0.0):
                await _settled(future)
        return future.result(0.0)

    def _watch(self, velocity: Velocity) -> None:
        """Since when the policy stands still of its own will."""
        end = self.timeline.end
        willed = end is not None and end >= self.robot.now
        speed = math.hypot(velocity.vx, velocity.vy)
        if not willed or speed > STANDS[0] or abs(velocity.omega) > STANDS[1]:
            self.stands_since = None
        elif self.stands_since is None:
            self.stands_since = self.robot.now

    async def _stand(self) -> None:
        """Waits until the robot was commanded to a stand-still."""
        for _ in range(round(LONGEST_STOP / TICK)):
            v = self.robot._runtime.commanded()
            if not self.robot.connected or (v.vx, v.vy, v.omega) == (0.0, 0.0, 0.0):
                return
            await self.robot.sleep(TICK)


async def _settled(future: Future[NDArray[np.float64]]) -> None:
    """Waits until there is a result or an error, for a while of wall time. Raises nothing."""
    waited = asyncio.wrap_future(future)
    await asyncio.wait([waited], timeout=PATIENCE)
    if waited.done():
        waited.exception()  # asyncio reports errors that are never read


def _in_thread(work: Callable[[], NDArray[np.float64]]) -> Future[NDArray[np.float64]]:
    """Runs in a thread that keeps no program from ending: what hangs cannot be stopped."""
    future: Future[NDArray[np.float64]] = Future()

    def run() -> None:
        try:
            future.set_result(work())
        except BaseException as error:
            future.set_exception(error)

    threading.Thread(target=run, name="policy", daemon=True).start()
    return future
