"""Feed-forward policies say what PyTorch and Stable-Baselines3 say, and bad files are one clear error each."""

from __future__ import annotations

import json
import subprocess
import sys
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from threewe import ConfigError
from threewe.benchmark import (
    Episode,
    MlpPolicy,
    Plan,
    Settings,
    mlp_from_sb3,
    mlp_from_torch,
    plan_run,
    results_of,
    run,
    write_bundle,
)
from threewe.benchmark.agents import identify
from threewe.benchmark.mlp import ENTRY
from threewe.benchmark.verifying import verify_bundle

safetensors = pytest.importorskip("safetensors.numpy")
ROOT = Path(__file__).resolve().parents[3]


def towards_the_goal(**fields: Any) -> MlpPolicy:
    """Drives ahead and turns to where the goal is: one layer, written by hand."""
    return MlpPolicy({"goal": 2}, [([[0.5, 0.0], [0.0, 0.5], [0.0, 1.0]], [0.0, 0.0, 0.0])], **fields)


def plan_of(file: Path) -> tuple[Plan, list[Episode]]:
    return plan_run("pointnav", str(file), split="val", scenes=["apartment_v1"], episodes=1, settings=Settings())


def drawn(seed: int, **fields: Any) -> MlpPolicy:
    """One of any size."""
    draw = np.random.default_rng(seed)
    sizes = [74, *draw.integers(1, 40, draw.integers(0, 4)).tolist(), 3]
    layers = [(draw.normal(size=(out, into)) / np.sqrt(into), draw.normal(size=out)) for into, out in pairwise(sizes)]
    return MlpPolicy(
        {"goal": 2, "lidar": 72},
        layers,
        mean=draw.normal(size=74),
        standard_deviation=draw.uniform(0.1, 9.0, 74),
        action_scale=draw.uniform(0.5, 1.0, 3),
        **fields,
    )


@pytest.mark.parametrize("activation", ["tanh", "relu", "elu", "silu"])
def test_it_says_what_torch_says(activation: str) -> None:
    torch = pytest.importorskip("torch")
    kind = {"tanh": torch.nn.Tanh, "relu": torch.nn.ReLU, "elu": torch.nn.ELU, "silu": torch.nn.SiLU}[activation]
    for seed in range(20):
        torch.manual_seed(seed)
        draw = np.random.default_rng(seed)
        hidden = draw.integers(1, 50, draw.integers(0, 4)).tolist()
        inner = [part for i, n in zip([74, *hidden], hidden, strict=False) for part in (torch.nn.Linear(i, n), kind())]
        last = torch.nn.Linear(([74, *hidden])[-1], 3, bias=seed % 2 == 0)
        network = torch.nn.Sequential(torch.nn.Sequential(*inner), last, *([torch.nn.Tanh()] if seed % 3 == 0 else []))
        policy = mlp_from_torch(network, {"lidar": 72, "goal": 2})
        values = draw.normal(size=(50, 74)).astype(np.float32)
        with torch.no_grad():
            expected = network(torch.from_numpy(values)).clamp(-1.0, 1.0).numpy()
        np.testing.assert_allclose(policy.forward(values), expected, atol=2e-6)


def test_it_says_what_stable_baselines_says_with_normalisation(tmp_path: Path) -> None:
    pytest.importorskip("stable_baselines3")
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecNormalize
    from threewe.gym.sb3 import SB3VecEnv

    batch = SB3VecEnv(
        task="navigation", num_envs=4, scene="corridor_v1", observations=("velocity", "lidar", "goal"), lidar_beams=36
    )
    envs = VecNormalize(batch, clip_obs=2.0)
    model = PPO("MultiInputPolicy", envs, n_steps=16, batch_size=16, device="cpu", seed=1)
    model.learn(64)
    mlp_from_sb3(model, envs, control_rate=5.0).save(tmp_path / "policy.safetensors")
    policy = MlpPolicy.load(tmp_path / "policy.safetensors")
    assert policy.options["control_rate"] == 5.0
    draw = np.random.default_rng(1)
    for _ in range(50):
        row = {
            "goal": draw.uniform(1.0, 8.0, 2).astype(np.float32),
            "lidar": draw.uniform(0.0, 12.0, 36).astype(np.float32),
            "velocity": draw.normal(size=3).astype(np.float32),
        }
        expected, _ = model.predict(envs.normalize_obs(row), deterministic=True)
        np.testing.assert_allclose(policy.act(row), expected, atol=2e-6)
    partly = VecNormalize(batch, norm_obs_keys=["goal"])
    with pytest.raises(ConfigError, match="normalize all of them, or none"):
        mlp_from_sb3(model, partly)
    assert not np.asarray(mlp_from_sb3(model).mean).any()


def test_networks_of_other_parts_are_refused() -> None:
    torch = pytest.importorskip("torch")
    nn = torch.nn
    with pytest.raises(ConfigError, match="LayerNorm has no place"):
        mlp_from_torch(nn.Sequential(nn.Linear(2, 4), nn.LayerNorm(4), nn.Linear(4, 3)), {"goal": 2})
    with pytest.raises(ConfigError, match=r"its activations differ \(relu, tanh\)"):
        mlp_from_torch([nn.Linear(2, 4), nn.ReLU(), nn.Linear(4, 4), nn.Tanh(), nn.Linear(4, 3)], {"goal": 2})
    with pytest.raises(ConfigError, match="ELU with alpha 2"):
        mlp_from_torch([nn.Linear(2, 4), nn.ELU(2.0), nn.Linear(4, 3)], {"goal": 2})
    with pytest.raises(ConfigError, match=r"layers\.0\.weight: expected shape \(4, 2\), got \(4, 5\)"):
        mlp_from_torch([nn.Linear(5, 4), nn.ReLU(), nn.Linear(4, 3)], {"goal": 2})
    with pytest.raises(ConfigError, match=r"layers\.0\.weight: expected shape \(3, 2\), got \(2, 2\)"):
        mlp_from_torch([nn.Linear(2, 2)], {"goal": 2})
    with pytest.raises(ConfigError, match="layers: expected 1 to 64, got 0"):
        mlp_from_torch([], {"goal": 2})


def test_a_file_keeps_all_of_it_and_is_the_same_again(tmp_path: Path) -> None:
    path, again = tmp_path / "policy.safetensors", tmp_path / "again.safetensors"
    for seed in range(20):
        policy = drawn(seed, activation="silu", input_clip=3.0, control_rate=5.0, goal_frame="map")
        policy.save(path)
        loaded = MlpPolicy.load(path)
        loaded.save(again)
        assert path.read_bytes() == again.read_bytes()
        values = np.random.default_rng(seed).normal(size=(20, 74))
        assert np.array_equal(loaded.forward(values), policy.forward(values))
        wanted = {"observations": ("goal", "lidar"), "lidar_beams": 72, "goal_frame": "map", "control_rate": 5.0}
        assert loaded.options == wanted


def test_a_policy_drives_stops_at_its_goal_and_replays(tmp_path: Path) -> None:
    file = tmp_path / "towards.safetensors"
    towards_the_goal().save(file)
    plan, listed = plan_of(file)
    outcomes = run(plan, listed, tmp_path / "journal.jsonl", workers=0)
    results = results_of(plan, listed, outcomes)
    assert (results["agent"]["kind"], results["agent"]["privileged"]) == ("act", False)
    assert len(results["agent"]["source"]) == 64
    [row] = results["episode_results"]
    assert (row["end"], row["failure"], row["metrics"]["success"]) == ("stop", "", 1.0)
    write_bundle(tmp_path / "run.zip", results, outcomes)
    verify_bundle(tmp_path / "run.zip", workers=0)


def test_the_example_exports_what_the_benchmark_drives(tmp_path: Path) -> None:
    pytest.importorskip("stable_baselines3")
    example = ROOT / "examples/12_end_to_end.py"
    command = [sys.executable, "-W", "error", example, "--quick", "--save", "learned.safetensors"]
    subprocess.run(command, cwd=tmp_path, check=True)
    identity = identify("pointnav", str(tmp_path / "learned.safetensors"))
    assert identity.kind == "act"
    policy = MlpPolicy.load(tmp_path / "learned.safetensors")
    assert dict(policy.observations) == {"goal": 2, "lidar": 72}
    assert policy.input_clip == 10.0


def described(**changes: Any) -> dict[str, Any]:
    wanted: dict[str, Any] = {
        "format": "threewe-mlp/1",
        "observations": [["goal", 2]],
        "sizes": [2, 3],
        "activation": "tanh",
    }
    return {name: value for name, value in {**wanted, **changes}.items() if value is not ...}


def tensors(**changes: Any) -> dict[str, Any]:
    wanted = {
        "input.mean": np.zeros(2, np.float32),
        "input.standard_deviation": np.ones(2, np.float32),
        "layers.0.weight": np.zeros((3, 2), np.float32),
        "layers.0.bias": np.zeros(3, np.float32),
        "action.scale": np.ones(3, np.float32),
    }
    changed = {name.replace("__", "."): value for name, value in changes.items()}
    return {name: value for name, value in {**wanted, **changed}.items() if value is not ...}


def packed(metadata: Any = None, **changes: Any) -> bytes:
    text = json.dumps(described() if metadata is None else metadata)
    content: bytes = safetensors.save(tensors(**changes), metadata={ENTRY: text})
    return content


WHOLE = packed()
BAD = {
    "no metadata": (safetensors.save(tensors()), "its metadata has no entry 'threewe'"),
    "other metadata": (safetensors.save(tensors(), metadata={"format": "pt"}), "its metadata has no entry 'threewe'"),
    "metadata is no JSON": (safetensors.save(tensors(), metadata={ENTRY: "{"}), "metadata 'threewe': Expecting"),
    "deep metadata": (safetensors.save(tensors(), metadata={ENTRY: "[" * 100_000}), "metadata 'threewe': "),
    "a list": (packed([1]), "expected format 'threewe-mlp/1'"),
    "another format": (packed(described(format="threewe-mlp/2")), "expected format 'threewe-mlp/1'"),
    "a field is missing": (packed(described(activation=...)), "missing field 'activation'"),
    "an unknown field": (packed(described(input_clp=1.0)), "did you mean 'input_clip'"),
    "no sizes": (packed(described(sizes=[])), "sizes: expected the inputs"),
    "sizes of text": (packed(described(sizes=["2", 3])), "sizes: expected the inputs"),
    "sizes without end": (packed(described(sizes=[2] * 70)), "sizes: expected the inputs"),
    "sizes of other tensors": (packed(described(sizes=[2, 8, 3])), r"layers\.0\.weight: expected shape \(8, 2\)"),
    "inputs of another size": (
        packed(described(observations=[["goal", 2], ["pose", 3]])),
        r"input\.mean: expected shape \(5,\), got \(2,\)",
    ),
    "four outputs": (
        packed(
            described(sizes=[2, 4]),
            layers__0__weight=np.zeros((4, 2), np.float32),
            layers__0__bias=np.zeros(4, np.float32),
            action__scale=np.ones(4, np.float32),
        ),
        r"layers\.0\.weight: expected shape \(3, 2\), got \(4, 2\)",
    ),
    "an unknown observation": (packed(described(observations=[["gaol", 2]])), "did you mean 'goal'"),
    "an image": (packed(described(observations=[["image", 12288]])), "images and maps need an ONNX graph"),
    "an observation of another length": (packed(described(observations=[["goal", 3]])), "goal has 2 numbers, not 3"),
    "an observation twice": (packed(described(observations=[["goal", 2], ["goal", 2]])), "each once"),
    "observations by name": (packed(described(observations={"goal": 2})), "expected pairs of name and length"),
    "an unknown activation": (packed(described(activation="than")), "did you mean 'tanh'"),
    "an activation that is none": (packed(described(activation=7)), "unknown activation '7'"),
    "a negative clip": (packed(described(input_clip=-1.0)), "input_clip: expected a number above 0, got -1.0"),
    "a rate of text": (packed(described(control_rate="5")), "control_rate: expected a number above 0, got '5'"),
    "another frame": (packed(described(goal_frame="odom")), "goal_frame: expected 'robot' or 'map'"),
    "a weight is NaN": (
        packed(layers__0__weight=np.full((3, 2), np.nan, np.float32)),
        r"layers\.0\.weight: not all of its numbers are finite",
    ),
    "an infinite bias": (packed(layers__0__bias=np.full(3, np.inf, np.float32)), "bias: not all of its numbers"),
    "no spread": (packed(input__standard_deviation=np.zeros(2, np.float32)), "expected numbers above 0"),
    "a wrong shape": (
        packed(layers__0__weight=np.zeros((2, 3), np.float32)),
        r"layers\.0\.weight: expected shape \(3, 2\), got \(2, 3\)",
    ),
    "double precision": (packed(layers__0__bias=np.zeros(3)), r"layers\.0\.bias: expected F32, got F64"),
    "a tensor is missing": (packed(input__mean=...), r"missing tensor 'input\.mean'"),
    "an unknown tensor": (packed(layers__0__wieght=np.zeros(1, np.float32)), r"did you mean 'layers\.0\.weight'"),
    "cut off": (WHOLE[:-1], "no whole safetensors file"),
    "cut off in its header": (WHOLE[:40], "no whole safetensors file"),
    "empty": (b"", "no whole safetensors file"),
    "no safetensors": (b"PK\x03\x04\x00\x00\x00\x00not at all", "no safetensors file: its header of 67324752 bytes"),
    "a huge header": ((2**40).to_bytes(8, "little") + WHOLE[8:], "its header of 1099511627776 bytes would be larger"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_is_one_error_that_names_it(name: str, tmp_path: Path) -> None:
    content, message = BAD[name]
    path = tmp_path / "bad.safetensors"
    path.write_bytes(content)
    with pytest.raises(ConfigError, match=message) as refused:
        identify("pointnav", str(path))
    assert str(refused.value).startswith(f"{path}: ")
    assert "\n" not in str(refused.value)


def test_no_byte_of_a_file_makes_another_error(tmp_path: Path) -> None:
    """Files with bytes changed or cut off are read, or refused."""
    path = tmp_path / "bad.safetensors"
    draw = np.random.default_rng(5)
    for _ in range(500):
        content = bytearray(WHOLE)
        for _ in range(draw.integers(1, 4)):
            content[draw.integers(len(content))] = draw.integers(256)
        path.write_bytes(content[: draw.integers(len(content))] if draw.random() < 0.2 else content)
        with suppress(ConfigError), np.errstate(over="ignore", invalid="ignore"):
            assert MlpPolicy.load(path).forward(np.ones(2)).shape == (3,)


def test_what_a_task_has_not_is_named_before_the_run(tmp_path: Path) -> None:
    towards_the_goal().save(tmp_path / "towards.safetensors")
    MlpPolicy({"lidar": 71}, [(np.zeros((3, 71)), np.zeros(3))]).save(tmp_path / "odd.safetensors")
    with pytest.raises(ConfigError, match=r"could not be run: lidar_beams: every k-th of the 360 beams"):
        run(*plan_of(tmp_path / "odd.safetensors"), tmp_path / "journal.jsonl", workers=0)
    with pytest.raises(ConfigError, match="unknown observation of exploration 'goal'"):
        identify("exploration", str(tmp_path / "towards.safetensors"))
    with pytest.raises(ConfigError, match="no such file"):
        identify("pointnav", str(tmp_path / "none.safetensors"))
    (tmp_path / "large.safetensors").write_bytes(WHOLE)
    with (tmp_path / "large.safetensors").open("r+b") as file:
        file.truncate(65 << 20)
    with pytest.raises(ConfigError, match="larger than"):
        identify("pointnav", str(tmp_path / "large.safetensors"))
