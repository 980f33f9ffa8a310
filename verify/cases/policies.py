"""Policies that fail, folders that are none, and policies that drive twice."""

import asyncio
import json
import pickle
import random
import threading
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import onnx
import torch
from threewe import ConfigError, Kinematics, Robot
from threewe.ai import CameraInput, Policy, Quantity, VLARunner, read_policy
from threewe.ai.network import Network, to_onnx
from threewe.ai.training import write_policy

from verify.harness import Case

HEIGHT, WIDTH, CHUNK = 24, 32, 10
FAULTS = {"raises": "policy_error", "nan": "policy_error", "shape": "policy_error", "hangs": "starved"}
USABLE_WITHIN = 0.25  # [s]


def untrained(folder: Path, seed: int) -> Path:
    """The folder of a policy with drawn weights: it drives, wherever."""
    torch.manual_seed(seed)
    policy = Policy(
        folder=folder,
        kinematics=Kinematics.holonomic,
        cameras=(CameraInput("camera", HEIGHT, WIDTH, "rgb"),),
        state=(),
        action=tuple(
            Quantity(name, unit, mean, 1.0)
            for name, unit, mean in (("vx", "m/s", 0.2), ("vy", "m/s", 0.0), ("omega", "rad/s", 0.3))
        ),
        rate=10.0,
        chunk=CHUNK,
        latency=0.1,
        merge="blend",
        language=True,
        training={},
    )
    write_policy(policy, to_onnx(Network(HEIGHT, WIDTH, CHUNK, 3).eval(), policy))
    return folder


async def drive(runner: VLARunner, seed: int, timeout: float) -> tuple[str, list[tuple[float, ...]], float, bool]:
    """How a run ended, what was commanded, how long it took to stand [s], and whether the robot then turned."""
    commands: list[tuple[float, ...]] = []
    async with Robot(image_size=(HEIGHT, WIDTH), seed=seed) as robot:
        robot.observe(lambda tick: commands.append(tuple(tick.requested)))
        begun = robot.now
        result = await runner.run(robot, "go to the chair", timeout=timeout)
        standing = robot.now - begun - result.duration
        turned = await robot.rotate(0.2)
    return result.reason, commands, standing, turned.success


def fail(seed: int) -> Case:
    """A fault of a policy at a drawn moment."""
    draw = random.Random(seed)
    fault = draw.choice(sorted(FAULTS))
    with TemporaryDirectory() as folder:
        runner = VLARunner.from_pretrained(untrained(Path(folder, "policy"), seed))
        predict, left, forever = runner.predict_chunk, [draw.randrange(1, 20)], threading.Event()

        def faulty(*args: object, **options: object) -> object:
            left[0] -= 1
            if left[0] > 0:
                return predict(*args, **options)
            if fault == "raises":
                raise RuntimeError("drawn")
            if fault == "hangs":
                forever.wait(60)
            return np.full((CHUNK, 3), np.nan) if fault == "nan" else np.zeros((2, 3))

        runner.predict_chunk = faulty
        reason, _, standing, usable = asyncio.run(drive(runner, seed, 5.0))
        forever.set()
    named = reason == FAULTS[fault]
    return {"fault": fault, "named": named, "stood": standing <= USABLE_WITHIN + 1e-9, "usable": usable}


def repeat(seed: int) -> Case:
    """The same policy, twice in the same world."""
    with TemporaryDirectory() as folder:
        runner = VLARunner.from_pretrained(untrained(Path(folder, "policy"), seed))
        first, second = (asyncio.run(drive(runner, seed, 3.0)) for _ in range(2))
    return {"same": first == second}


def spoil(seed: int) -> Case:
    """One folder with a drawn mistake or attack."""
    draw = random.Random(seed)
    name = draw.choice(sorted(SPOILERS))
    with TemporaryDirectory() as base:
        folder = untrained(Path(base, "policy"), 1)
        SPOILERS[name](folder, draw)
        before = {file: file.lstat().st_mtime_ns for file in Path(base).rglob("*")}
        try:
            read_policy(folder)
        except ConfigError as error:
            refused = str(folder) in str(error)
        else:
            refused = False
        after = {file: file.lstat().st_mtime_ns for file in Path(base).rglob("*")}
    return {"attack": name, "refused": refused, "untouched": before == after}


class Touch:
    """Makes a file where it is unpickled."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Callable[[Path], None], tuple[Path]]:
        return Path.touch, (self.path,)


def _pickled(folder: Path, draw: random.Random) -> None:
    suffix = draw.choice([".pt", ".pth", ".bin", ".ckpt", ".pkl", ".txt", ".json", ""])
    content = pickle.dumps(Touch(folder / "run"), protocol=draw.choice([2, 3, 4, 5]))
    (folder / f"extra{suffix}").write_bytes(content)


def _link(folder: Path, draw: random.Random) -> None:
    name = draw.choice(["policy.json", "model.onnx"])
    (folder / name).rename(folder.parent / name)
    (folder / name).symlink_to(Path("..") / name)


def _cut(folder: Path, draw: random.Random) -> None:
    file = folder / draw.choice(["policy.json", "model.onnx"])
    content = file.read_bytes()
    file.write_bytes(content[: draw.randrange(len(content) - 2)])


def _description(folder: Path, draw: random.Random) -> None:
    content = json.loads((folder / "policy.json").read_text())
    field = draw.choice(sorted(content))
    if draw.random() < 0.3:
        del content[field]
    else:
        content[field] = draw.choice([None, -1, 1e308, "../x", [], [[]], {"a": {}}, float("nan")])
    (folder / "policy.json").write_text(json.dumps(content))


def _nested(folder: Path, draw: random.Random) -> None:
    depth = draw.randrange(5_000, 200_000)
    (folder / "policy.json").write_text(draw.choice(["[", '{"a":']) * depth)


def _graph(folder: Path, draw: random.Random) -> None:
    model = onnx.load(str(folder / "model.onnx"))
    tensors = [tensor for tensor in model.graph.initializer if tensor.data_type == onnx.TensorProto.FLOAT]
    tensor = draw.choice(tensors)
    kind = draw.choice(["nan", "external", "huge", "domain", "operator", "missing", "wide"])
    if kind == "nan":
        values = onnx.numpy_helper.to_array(tensor).copy()
        values.flat[draw.randrange(values.size)] = draw.choice([np.nan, np.inf])
        tensor.CopyFrom(onnx.numpy_helper.from_array(values, tensor.name))
    elif kind == "external":
        tensor.data_location = onnx.TensorProto.EXTERNAL
        tensor.external_data.add(key="location", value=draw.choice(["../secret", "/etc/passwd", "weights"]))
    elif kind == "huge":
        tensor.dims[:] = [2**30, 2**30]
    elif kind == "domain":
        draw.choice(model.graph.node).domain = "com.microsoft"
    elif kind == "operator":
        draw.choice(model.graph.node).op_type = draw.choice(["Loop", "If", "Scan", "Expand", "Tile", "RandomNormal"])
    elif kind == "missing":
        model.graph.initializer.remove(tensor)
    else:
        pads = next(a for n in model.graph.node if n.op_type == "Conv" for a in n.attribute if a.name == "pads")
        pads.ints[:] = [2 ** draw.randrange(14, 40)] * 4
    (folder / "model.onnx").write_bytes(model.SerializeToString())


SPOILERS: dict[str, Callable[[Path, random.Random], None]] = {
    "pickle": _pickled,
    "link": _link,
    "cut": _cut,
    "description": _description,
    "nested": _nested,
    "graph": _graph,
    "graph again": _graph,  # there are many ways
}
