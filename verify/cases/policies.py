"""Policies that fail, folders that are none, and policies that drive twice."""

import asyncio
import bz2
import gzip
import json
import lzma
import pickle
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import onnx
import torch
from numpy.typing import NDArray
from safetensors.numpy import load_file, save_file
from threewe import ConfigError, Kinematics, Robot, TickView
from threewe.ai import CameraInput, Policy, Quantity, VLARunner
from threewe.ai.agent import PolicyAgent
from threewe.ai.calibration import calibration_feeds
from threewe.ai.evaluating import instruction_to_another
from threewe.ai.folder import write_policy
from threewe.ai.network import Network, to_onnx
from threewe.ai.quantizing import write_int8
from threewe.benchmark.attempt import Settings, attempt_with
from threewe.benchmark.episodes import Episode, load_episodes
from threewe.benchmark.sampling import generated_in_sight

from verify.cases import act_checkpoints
from verify.harness import Case

HEIGHT, WIDTH, CHUNK = 24, 32, 10
FILES = ("policy.json", "model.onnx")
TICK = 0.02  # [s]
_FOLDER = TemporaryDirectory()


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


@dataclass(frozen=True)
class Drive:
    """One run of a policy."""

    reason: str
    wanted: list[tuple[float, ...]]
    """of the gate, tick by tick"""
    standing: float
    """[s] that it took to stand since nothing was wanted"""
    unguided: float
    """[s] that it moved since its last chunk of actions came"""
    usable: bool
    """it then turned as it should"""


async def drive(runner: VLARunner, seed: int, timeout: float, backend: str = "mock") -> Drive:
    """Drives by a policy, and turns the robot afterwards."""
    requested: list[tuple[float, ...]] = []
    commanded: list[tuple[float, ...]] = []
    actions, came = runner._actions, 0
    async with Robot(backend, image_size=(HEIGHT, WIDTH), seed=seed) as robot:

        def noted(*given: Any) -> NDArray[np.float64]:
            nonlocal came
            chunk = actions(*given)
            if np.isfinite(chunk).all():
                came = len(commanded)
            return chunk

        def watch(tick: TickView) -> None:
            requested.append(tuple(tick.requested))
            commanded.append(tuple(tick.commanded))

        robot.observe(watch)
        runner._actions = noted  # type: ignore[method-assign]
        result = await runner.run(robot, "go to the chair" if runner.policy.language else "", timeout=timeout)
        runner._actions = actions  # type: ignore[method-assign]
        await robot.sleep(0.3)
        standing, unguided = (TICK * (_moving(commanded) - since) for since in (_moving(requested), came))
        wanted = list(requested)
        turned = await robot.rotate(0.2)
    return Drive(result.reason, wanted, standing, unguided, turned.success)


def _moving(velocities: list[tuple[float, ...]]) -> int:
    """Ticks until the last that moves."""
    return max((i + 1 for i, velocity in enumerate(velocities) if any(velocity)), default=0)


def go(seed: int, episodes: str, backends: list[str], latencies: list[float], others: bool) -> Case:
    """The shipped policy goes to a thing in sight: on each backend, with each latency, and where another is named."""
    episode = _episode(seed, episodes)
    won: Case = {backend: reaches(episode, Settings(backend=backend)) for backend in backends}
    for latency in latencies:
        won[f"{latency:g} s"] = reaches(episode, Settings(), latency=latency)
    if others and (instruction := instruction_to_another(episode)):
        won["other"] = reaches(episode, Settings(), instruction)
    return won


@cache
def _eight_bits() -> Path:
    """The shipped policy in eight bits."""
    runner = VLARunner.from_pretrained("goto_v1")
    folder = Path(_FOLDER.name, "int8")
    write_int8(runner.policy, calibration_feeds(runner, None), folder)
    return folder


def go_in_eight_bits(seed: int) -> Case:
    """The shipped policy goes to a thing in sight, in 32 and in 8 bits."""
    episode = _episode(seed, "generated")
    return {"32": reaches(episode, Settings()), "8": reaches(episode, Settings(), policy=_eight_bits())}


def reaches(
    episode: Episode,
    settings: Settings,
    instruction: str = "",
    latency: float | None = None,
    policy: str | Path = "goto_v1",
) -> bool:
    """Whether a policy, the shipped one unless said, gets there."""
    agent = PolicyAgent(policy, instruction, latency)
    return bool(attempt_with("objectnav", episode, agent, settings)["metrics"]["success"])


def _episode(seed: int, episodes: str) -> Episode:
    """One of a frozen set, with noise of the seed; or one in a building that follows from it."""
    if episodes == "generated":
        return next(generated_in_sight(f"verify/{seed}"))
    listed = load_episodes(episodes)["episodes"]
    return replace(listed[seed % len(listed)], seed=seed)


def repeat(seed: int) -> Case:
    """The same policy, twice in the same world."""
    with TemporaryDirectory() as folder:
        runner = VLARunner.from_pretrained(untrained(Path(folder, "policy"), seed))
        first, second = (asyncio.run(drive(runner, seed, 3.0)) for _ in range(2))
    return {"same": first == second}


def spoil(seed: int) -> Case:
    """One folder with a drawn mistake or attack."""
    draw = random.Random(seed)
    name = draw.choice([*sorted(SPOILERS), *sorted(ACT_SPOILERS)])
    with TemporaryDirectory() as base:
        if name in ACT_SPOILERS:
            folder = act_checkpoints.write(Path(base, "policy"), ACT)
            ACT_SPOILERS[name](folder, draw)
        else:
            folder = untrained(Path(base, "policy"), 1)
            SPOILERS[name](folder, draw)
        before = {file: file.lstat().st_mtime_ns for file in Path(base).rglob("*")}
        try:
            VLARunner.from_pretrained(folder, **(ACT_NAMES if name in ACT_SPOILERS else {}))
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


def _link(folder: Path, draw: random.Random, files: Sequence[str] = FILES) -> None:
    name = draw.choice(files)
    (folder / name).rename(folder.parent / name)
    (folder / name).symlink_to(Path("..") / name)


def _cut(folder: Path, draw: random.Random, files: Sequence[str] = FILES) -> None:
    file = folder / draw.choice(files)
    content = file.read_bytes()
    file.write_bytes(content[: draw.randrange(len(content) - 2)])


def _description(folder: Path, draw: random.Random) -> None:
    content = json.loads((folder / "policy.json").read_text())
    field = draw.choice(sorted(content))
    if draw.random() < 0.3:
        del content[field]
    else:
        wrong = [None, -1, 1e308, "../x", [], [[]], {"a": {}}, float("nan")]
        content[field] = draw.choice([value for value in wrong if value != content[field]])
    (folder / "policy.json").write_text(json.dumps(content))


def _nested(folder: Path, draw: random.Random) -> None:
    depth = draw.randrange(5_000, 200_000)
    (folder / "policy.json").write_text(draw.choice(["[", '{"a":']) * depth)


def _loop(folder: Path, draw: random.Random) -> None:
    """Layers that follow from themselves, or from those after them."""
    model = onnx.load(str(folder / "model.onnx"))
    nodes = model.graph.node
    first = draw.randrange(len(nodes) - 1)
    nodes[first].input[0] = nodes[draw.randrange(first, len(nodes))].output[0]
    (folder / "model.onnx").write_bytes(model.SerializeToString())


def _bomb(folder: Path, draw: random.Random) -> None:
    """Little that is to become much."""
    kind = draw.choice(["archive", "sparse", "files", "numbers", "text"])
    if kind == "archive":
        content = draw.choice([gzip, bz2, lzma]).compress(bytes(10**7))
        (folder / draw.choice(["model.onnx", "more", "weights.safetensors"])).write_bytes(content)
    elif kind == "sparse":
        with (folder / draw.choice(FILES)).open("r+b") as file:
            file.truncate(2**33)
    elif kind == "files":
        for number in range(1001):
            (folder / f"{number}").touch()
    elif kind == "numbers":
        content = json.loads((folder / "policy.json").read_text())
        content["state"] = [[1] * 1000] * 2000
        (folder / "policy.json").write_text(json.dumps(content))
    else:
        text = (folder / "policy.json").read_text()
        (folder / "policy.json").write_text(text.replace('"training": {', '"training": {"a": "' + "a" * 10**7 + '"'))


def _stages(folder: Path, draw: random.Random) -> None:
    """Claims an encoder for a Hailo that is none, or whose head does not fit."""
    content = json.loads((folder / "policy.json").read_text())
    content["features"] = draw.choice([[4, 4, 4], [0, 1, 1], [2**60, 1, 1], [4], "4", None])
    (folder / "policy.json").write_text(json.dumps(content))
    if draw.random() < 0.7:
        (folder / "head.onnx").write_bytes((folder / "model.onnx").read_bytes())
    (folder / "encoder.hef").write_bytes(draw.choice([b"", b"\x01HEF", b"MZ\x90\x00" * 100]))


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
    "loop": _loop,
    "bomb": _bomb,
    "stages": _stages,
}


ACT = act_checkpoints.Shape(32, 32, state=0, text=False, options={"n_encoder_layers": 1})
ACT_NAMES = {"rate": 10, "rename": {"action": ["vx", "vy", "omega"]}}
ACT_JSON = ("config.json", "policy_preprocessor.json", "policy_postprocessor.json")
ACT_FILES = (*ACT_JSON, "model.safetensors")


def _act_class(folder: Path, draw: random.Random) -> None:
    """A processor that names code to run."""
    file = folder / draw.choice(ACT_JSON[1:])
    content = json.loads(file.read_text())
    step = {"class": draw.choice(["os.system", "subprocess.run", "builtins.exec"]), "config": {"command": "touch run"}}
    content["steps"].insert(draw.randrange(len(content["steps"]) + 1), step)
    file.write_text(json.dumps(content))


def _act_tensors(folder: Path, draw: random.Random) -> None:
    file = draw.choice([folder / "model.safetensors", *folder.glob("policy_pre*.safetensors")])
    tensors = load_file(str(file))
    used = "model." if file.name == "model.safetensors" else "observation.images.camera."
    name = draw.choice(sorted(n for n in tensors if n.startswith(used) and not n.endswith((".min", ".max"))))
    kind = draw.choice(["nan", "missing", "shape", "type", *(["extra"] if used == "model." else [])])
    if kind == "nan":
        tensors[name] = np.full_like(tensors[name], draw.choice([np.nan, np.inf]))
    elif kind == "missing":
        del tensors[name]
    elif kind == "shape":
        tensors[name] = np.zeros((7, *tensors[name].shape), np.float32)
    elif kind == "type":
        tensors[name] = tensors[name].astype(draw.choice([np.float64, np.float16, np.int64]))
    else:
        tensors["model.more"] = np.zeros(3, np.float32)
    save_file(tensors, str(file))


def _act_claims(folder: Path, draw: random.Random) -> None:
    """A header that claims what is not there."""
    shape = draw.choice([[2**60], [-1], [2**31, 2**31]])
    header = json.dumps(
        {"model.action_head.bias": {"dtype": "F32", "shape": shape, "data_offsets": [0, 2**62]}}
    ).encode()
    length = draw.choice([len(header), 2**62, 2**20])
    (folder / "model.safetensors").write_bytes(length.to_bytes(8, "little") + header)


def _act_nested(folder: Path, draw: random.Random) -> None:
    (folder / draw.choice(ACT_JSON)).write_text(draw.choice(["[", '{"a":']) * draw.randrange(5_000, 200_000))


def _act_config(folder: Path, draw: random.Random) -> None:
    content = json.loads((folder / "config.json").read_text())
    fields = ("type", "input_features", "output_features", "vision_backbone", "dim_model", "n_heads", "chunk_size")
    field = draw.choice([*fields, "n_encoder_layers", "n_decoder_layers", "latent_dim", "pre_norm"])
    content[field] = draw.choice([None, -1, 2**60, 1e308, "../x", [], {"a": {}}, float("nan")])
    (folder / "config.json").write_text(json.dumps(content))


def _act_path(folder: Path, draw: random.Random) -> None:
    """Statistics that are elsewhere."""
    file = folder / draw.choice(ACT_JSON[1:])
    content = json.loads(file.read_text())
    step = next(step for step in content["steps"] if "state_file" in step)
    step["state_file"] = draw.choice(
        ["../outside.safetensors", "/etc/passwd", ".", "sub/../x.safetensors", "\0.safetensors"]
    )
    file.write_text(json.dumps(content))


ACT_SPOILERS: dict[str, Callable[[Path, random.Random], None]] = {
    "ACT: class": _act_class,
    "ACT: tensors": _act_tensors,
    "ACT: claims": _act_claims,
    "ACT: cut": partial(_cut, files=ACT_FILES),
    "ACT: nested": _act_nested,
    "ACT: config": _act_config,
    "ACT: path": _act_path,
    "ACT: link": partial(_link, files=ACT_FILES),
    "ACT: pickle": _pickled,
}
