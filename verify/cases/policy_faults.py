"""What goes wrong with policies while they drive, wherever they run, and what a red thing is in their networks."""

import asyncio
import json
import os
import random
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any

import numpy as np
import threewe
from numpy.typing import NDArray
from threewe import Features, Pose2D, SensorInfo, SensorType, Velocity
from threewe.ai import VLARunner
from threewe.ai.folder import image_input
from threewe.ai.serving import PolicyServer
from threewe.backend import Backend, CameraReading, LidarReading, OdometryReading
from websockets.exceptions import ConnectionClosed
from websockets.sync.server import serve

from verify.cases import act_checkpoints
from verify.cases.policies import CHUNK, HEIGHT, WIDTH, drive, untrained
from verify.harness import Case

FAKE_LEROBOT = Path(__file__).parents[2] / "tests/python/ai/fake_lerobot"
USABLE_WITHIN = 0.25  # [s]
FOREVER = 30.0  # [s]
LATE = 0.3  # [s]
NAMES = ["vx", "vy", "omega"]
CHILD = act_checkpoints.Shape(HEIGHT, WIDTH, text=False, options={"type": "fake", "n_obs_steps": 2})


class Watching(Backend):
    """A robot in an empty hall that sees one colour, until its camera stops."""

    color: NDArray[np.uint8] = np.full((HEIGHT, WIDTH, 3), 90, np.uint8)
    until = float("inf")  # [s]

    pose, now = Pose2D(), 0.0

    @property
    def features(self) -> Features:
        """A camera, and what drives."""
        sensors = [
            SensorInfo("lidar", SensorType.lidar, 10.0),
            SensorInfo("odometry", SensorType.odometry, 50.0),
            SensorInfo("camera", SensorType.camera, 30.0),
        ]
        return Features(sensors, self.profile.kinematics, lockstep=True)

    def connect(self) -> None:
        """Nothing is to be done."""

    def disconnect(self) -> None:
        """Nothing is to be done."""

    def step(self, t: float, velocity: Velocity) -> Iterator[Any]:
        """Drives exactly."""
        seconds, self.now = t - self.now, t
        self.pose = self.pose * Pose2D(*(seconds * component for component in velocity))
        yield OdometryReading(measured=t, pose=self.pose, velocity=velocity)
        lidar = self.profile.lidar
        if round(t / 0.02) % 5 == 0:
            yield LidarReading(measured=t, ranges=np.full(lidar.beams, lidar.range_max, np.float32))
        if round(t / 0.02) % 2 == 0 and t < self.until:
            yield CameraReading(measured=t, color=self.color)


threewe.register_backend("watching", Watching)


def fail(seed: int) -> Case:
    """A fault at a drawn moment of a run."""
    draw = random.Random(seed)
    fault = draw.choice(sorted(FAULTS))
    inject, reasons = FAULTS[fault]
    with TemporaryDirectory() as folder, ExitStack() as stack:
        runner, backend = inject(Path(folder), seed, draw.randrange(1, 20), stack)
        driven = asyncio.run(drive(runner, seed, 5.0, backend))
    ends = (runner.policy.chunk - 1) / runner.policy.rate  # the timeline, after its last chunk came, at the latest
    stood = driven.standing <= USABLE_WITHIN + 1e-9 and driven.unguided <= ends + USABLE_WITHIN + 1e-9
    case = {"fault": fault, "reason": driven.reason, "stood": stood, "usable": driven.usable}
    return {**case, "named": driven.reason in reasons}


def _here(folder: Path, seed: int, count: int, stack: ExitStack, act: Callable[..., Any]) -> tuple[VLARunner, str]:
    """A policy of this process, which acts otherwise from its `count`-th inference on."""
    runner = VLARunner.from_pretrained(untrained(folder / "policy", seed))
    infer, left, forever = runner._engine.infer, [count], threading.Event()
    stack.callback(forever.set)

    def inferred(*args: Any) -> Any:
        left[0] -= 1
        return infer(*args) if left[0] > 0 else np.asarray(act(forever))[None]

    runner._engine = SimpleNamespace(infer=inferred)  # type: ignore[assignment]
    return runner, "mock"


def _raise(_: object) -> Any:
    raise RuntimeError("drawn")


def _late(_: object) -> Any:
    time.sleep(LATE)
    return np.tile([-0.2, 0.0, -0.3], (CHUNK, 1))  # the means of `untrained`: it wants to stand


def _child(folder: Path, seed: int, count: int, stack: ExitStack, fault: str) -> tuple[VLARunner, str]:
    """A checkpoint in a process of its own, which is killed, or does what it should not."""
    checkpoint = act_checkpoints.write(folder / "fake", CHILD, seed)
    (checkpoint / "model.safetensors").write_bytes(b"")
    config = {**CHILD.config(), **({"fake_fault": fault} if fault != "killed" else {})}
    (checkpoint / "config.json").write_text(json.dumps(config))
    processor = json.loads((checkpoint / "policy_preprocessor.json").read_text())
    processor["steps"].append({"registry_name": "tokenizer_processor", "config": {"tokenizer_name": "none"}})
    (checkpoint / "policy_preprocessor.json").write_text(json.dumps(processor))
    rename = {"action": NAMES, "observation.state": NAMES}
    before = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = str(FAKE_LEROBOT)
    try:
        runner = VLARunner.from_pretrained(checkpoint, python=sys.executable, rate=10, rename=rename)
    finally:
        os.environ.update({"PYTHONPATH": before}) if before else os.environ.pop("PYTHONPATH")
    engine: Any = runner._engine
    stack.callback(engine.close)
    if fault == "killed":
        infer, left = engine.infer, [count]

        def killed(*args: Any) -> Any:
            left[0] -= 1
            if left[0] == 0:
                os.kill(engine._process.pid, signal.SIGKILL)
            return infer(*args)

        runner._engine = SimpleNamespace(infer=killed)  # type: ignore[assignment]
    return runner, "mock"


def _server(folder: Path, seed: int, count: int, stack: ExitStack, fault: str) -> tuple[VLARunner, str]:
    """A policy's server that goes, hangs or sends garbage at its `count`-th answer, or then has another policy."""
    here = VLARunner.from_pretrained(untrained(folder / "policy", seed))
    runner = VLARunner.from_pretrained(stack.enter_context(_served(PolicyServer(here), count, fault)))
    if fault == "rate":
        engine: Any = runner._engine
        infer, left = engine.infer, [count]

        def interrupted(*args: Any) -> Any:
            left[0] -= 1
            if left[0] == 0:  # the connection breaks off, and what is then at that address has another rate
                here.policy = replace(here.policy, rate=20.0)
                engine._close()
            return infer(*args)

        runner._engine = SimpleNamespace(infer=interrupted)  # type: ignore[assignment]
    return runner, "mock"


@contextmanager
def _served(server: PolicyServer, count: int, fault: str) -> Iterator[str]:
    left, over = [count], threading.Event()

    def talk(connection: Any) -> None:
        from threewe.ai.serving import description
        from threewe.ai.wire import pack

        with suppress(ConnectionClosed):
            connection.send(pack(description(server._runner.policy)))
            for message in connection:
                left[0] -= 1
                if left[0] <= 0 and fault == "gone":
                    return
                if left[0] <= 0 and fault == "hangs":
                    over.wait(FOREVER)
                connection.send(b"\xc1" if left[0] <= 0 and fault == "garbage" else server._answer(message))

    with server, serve(talk, "127.0.0.1", 0, compression=None) as spoiled:
        threading.Thread(target=spoiled.serve_forever, daemon=True).start()
        yield f"ws://127.0.0.1:{spoiled.socket.getsockname()[1]}"
        over.set()
        spoiled.shutdown()


def _camera(folder: Path, seed: int, count: int, _: ExitStack) -> tuple[VLARunner, str]:
    """A camera that stops."""
    Watching.until = 0.2 + 0.1 * count
    return VLARunner.from_pretrained(untrained(folder / "policy", seed)), "watching"


Inject = Callable[[Path, int, int, ExitStack], tuple[VLARunner, str]]
FAULTS: dict[str, tuple[Inject, tuple[str, ...]]] = {
    "raises": (lambda *given: _here(*given, _raise), ("policy_error",)),
    "NaN": (lambda *given: _here(*given, lambda _: np.full((CHUNK, 3), np.nan)), ("policy_error",)),
    "shape": (lambda *given: _here(*given, lambda _: np.zeros((2, 3))), ("policy_error",)),
    "hangs": (lambda *given: _here(*given, lambda forever: forever.wait(FOREVER)), ("starved",)),
    "late": (lambda *given: _here(*given, _late), ("reached",)),  # the world waits
    "child: killed": (lambda *given: _child(*given, "killed"), ("policy_error",)),
    "child: raises": (lambda *given: _child(*given, "raises"), ("policy_error",)),
    "child: exits": (
        lambda *given: _child(*given, "exits"),
        ("policy_error", "starved"),
    ),  # which takes a second where others work, too
    "child: garbage": (lambda *given: _child(*given, "garbage"), ("policy_error",)),
    "child: hangs": (lambda *given: _child(*given, "hangs"), ("starved",)),
    "server: gone": (lambda *given: _server(*given, "gone"), ("policy_error",)),
    "server: hangs": (lambda *given: _server(*given, "hangs"), ("policy_error",)),
    "server: garbage": (lambda *given: _server(*given, "garbage"), ("policy_error",)),
    "server: another rate": (lambda *given: _server(*given, "rate"), ("policy_error",)),
    "camera stops": (_camera, ("fault",)),
}
"""How each is made, and how a run may end by it."""


def see_red(seed: int) -> Case:
    """A red thing in front of a robot's camera: which channel of the network's input it lights up, by format."""
    draw = random.Random(seed)
    shown = {"red": (0, 0, 200), "blue": (200, 0, 0)}
    name = draw.choice(sorted(shown))
    Watching.color = np.full((HEIGHT, WIDTH, 3), draw.randrange(40), np.uint8)
    Watching.color[4:-4, 4:-4] = shown[name]  # BGR
    Watching.until = float("inf")
    kind = draw.choice(FORMATS)
    with TemporaryDirectory() as folder, ExitStack() as stack:
        runner, order = _of_format(kind, Path(folder), stack)
        fed: list[NDArray[np.float32]] = []
        _spy(runner, kind, fed)
        asyncio.run(drive(runner, seed, 0.6, "watching"))
    middle = fed[-1][0, :, HEIGHT // 2, WIDTH // 2]
    expected = order.index(name)
    others = [middle[i] for i in range(3) if i != expected]
    return {"format": kind, "right": bool(middle[expected] > 0.7 and max(others) < 0.2)}


FORMATS = ("ours, rgb", "ours, bgr", "LeRobot's ACT", "server", "child")
RGB, BGR = ("red", "green", "blue"), ("blue", "green", "red")
ACT = act_checkpoints.Shape(HEIGHT, WIDTH, state=0, text=False, options={"n_encoder_layers": 1})


def _of_format(kind: str, folder: Path, stack: ExitStack) -> tuple[VLARunner, tuple[str, ...]]:
    """A runner, and the order of channels in which its network was trained."""
    if kind == "LeRobot's ACT":
        rename = {"action": NAMES}
        return VLARunner.from_pretrained(act_checkpoints.write(folder / "act", ACT), rate=10, rename=rename), RGB
    if kind == "child":
        return _child(folder, 1, 0, stack, "none")[0], RGB
    made = untrained(folder / "policy", 1)
    order = BGR if kind == "ours, bgr" else RGB
    description = made / "policy.json"
    description.write_text(description.read_text().replace('"rgb"', '"bgr"' if order is BGR else '"rgb"'))
    runner = VLARunner.from_pretrained(made)
    if kind == "server":
        server = PolicyServer(runner)
        stack.enter_context(server)
        runner = VLARunner.from_pretrained(server.address)
        runner._served = server._runner  # type: ignore[attr-defined]
    return runner, order


def _spy(runner: VLARunner, kind: str, fed: list[NDArray[np.float32]]) -> None:
    """Keeps what the network gets, on the server's side for one."""
    network: Any = getattr(runner, "_served", runner)
    engine = network._engine
    infer = engine.infer

    def watched(feed: dict[str, NDArray[np.float32]], instruction: str) -> NDArray[np.float32]:
        fed.append(feed[image_input("camera")])
        result: NDArray[np.float32] = infer(feed, instruction)
        return result

    network._engine = SimpleNamespace(infer=watched)
    assert kind in FORMATS
