"""LeRobot's ACT, translated from its tensors: the same actions, matched names, and nothing of it is run."""

from __future__ import annotations

import asyncio
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from safetensors.numpy import load_file, save_file
from threewe import ConfigError, ContractError, Robot, Velocity
from threewe.ai import VLARunner
from threewe.data.lerobot import DatasetWriter

from verify.cases import act_checkpoints
from verify.cases.act_checkpoints import SHAPES, STATE, TEXT, Shape, TwinPolicy

NAMES = ["vx", "vy", "omega"]
GOLDEN = json.loads((Path(__file__).parents[1] / "golden" / "lerobot_act.json").read_text())
SMALL = Shape(32, 32, text=False, options={"n_encoder_layers": 1})


def renamed(shape: Shape) -> dict[str, list[str]]:
    return {"action": NAMES, **({STATE: NAMES} if shape.state else {})}


def load(folder: Path, shape: Shape) -> VLARunner:
    return VLARunner.from_pretrained(folder, rate=10, rename=renamed(shape))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return act_checkpoints.write(tmp_path_factory.mktemp("made") / "act", SMALL)


@pytest.fixture
def act(made: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(made, tmp_path / "act"))


@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("64", 3),
        ("120", 2),
        pytest.param("64", 12, marks=pytest.mark.nightly),
        pytest.param("120", 6, marks=pytest.mark.nightly),
        pytest.param("240", 3, marks=pytest.mark.nightly),
        pytest.param("480", 2, marks=pytest.mark.nightly),
    ],
)
def test_it_computes_what_the_published_network_does(tmp_path: Path, name: str, count: int) -> None:
    folder = act_checkpoints.write(tmp_path / "act", SHAPES[name])
    runner, twin = load(folder, SHAPES[name]), TwinPolicy(folder).exact()
    observations = act_checkpoints.observations(SHAPES[name], count, seed=3)
    ours = np.array([runner._engine.infer(each, "")[0] for each in observations])
    exact = np.array([twin.predict(each) for each in observations])
    largest = np.abs(ours - exact).max((0, 1)) / np.ptp(exact, (0, 1))
    assert largest.max() <= 1e-5


@pytest.mark.parametrize("name", list(GOLDEN))
def test_it_computes_what_lerobot_did(tmp_path: Path, name: str) -> None:
    runner = load(act_checkpoints.write(tmp_path / "act", SHAPES[name]), SHAPES[name])
    recorded = np.array(GOLDEN[name])
    observations = act_checkpoints.observations(SHAPES[name], len(recorded), seed=7)
    ours = np.array([runner._engine.infer(each, "")[0] for each in observations])
    assert (np.abs(ours - recorded).max((0, 1)) / np.ptp(recorded, (0, 1))).max() <= 2e-5  # both round


def test_pictures_states_and_instructions_go_in_by_their_names(tmp_path: Path) -> None:
    shape = Shape(24, 32, cameras=("front", "side"))
    folder = act_checkpoints.write(tmp_path / "act", shape)
    runner, twin = load(folder, shape), TwinPolicy(folder)
    random = np.random.default_rng(2)
    front, side = (random.integers(0, 256, (24, 32, 3), np.uint8) for _ in range(2))  # BGR
    chunk = runner.predict_chunk({"side": side, "front": front}, "go to the chair", velocity=Velocity(0.1, 0.2, 0.3))
    observation = {
        f"observation.images.{name}": (image[None, :, :, ::-1].transpose(0, 3, 1, 2) / 255).astype(np.float32)
        for name, image in (("front", front), ("side", side))
    }
    observation[STATE] = np.array([[0.1, 0.2, 0.3]], np.float32)
    observation[TEXT] = runner._embedding("go to the chair")
    assert chunk == pytest.approx(twin.predict(observation), abs=1e-5)
    for wrong, message in (
        (front, "image: one picture; the policy takes front, side"),
        ({"front": front, "rear": side}, "image: pictures of front, rear; the policy takes front, side"),
    ):
        with pytest.raises(ContractError, match=message):
            runner.predict(wrong, "go", velocity=Velocity())


def test_a_red_object_is_red_in_the_tensor(act: Path) -> None:
    weights = load_file(str(act / "model.safetensors"))
    red = np.zeros((32, 32, 3), np.uint8)
    red[:, :, 2] = 255  # BGR
    seen = {}
    for channel in range(3):  # a network that sees one colour alone
        kept = {**weights, "model.backbone.conv1.weight": weights["model.backbone.conv1.weight"].copy()}
        kept["model.backbone.conv1.weight"][:, [c for c in range(3) if c != channel]] = 0
        save_file(kept, str(act / "model.safetensors"))
        runner = load(act, SMALL)
        look = [runner.predict(image, velocity=Velocity()) for image in (red, np.zeros_like(red))]
        seen[channel] = np.abs(look[0] - look[1]).max()
    assert seen[0] > 1e-3
    assert seen[1] == seen[2] == 0


def test_a_translation_is_kept_beside_its_checkpoint_until_that_changes(act: Path) -> None:
    load(act, SMALL)
    (kept,) = act.glob("threewe-*")
    written = (kept / "model.onnx").stat().st_mtime_ns
    load(act, SMALL)
    assert (kept / "model.onnx").stat().st_mtime_ns == written
    weights = load_file(str(act / "model.safetensors"))
    weights["model.action_head.bias"] += 1
    save_file(weights, str(act / "model.safetensors"))
    load(act, SMALL)
    (new,) = act.glob("threewe-*")
    assert new != kept


def test_a_checkpoint_that_cannot_be_written_beside_is_loaded(act: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import threewe.ai.loading as loading

    right = loading.write_policy

    def only_elsewhere(policy: Any, graph: bytes) -> None:
        if act in policy.folder.parents:
            raise PermissionError
        right(policy, graph)

    monkeypatch.setattr(loading, "write_policy", only_elsewhere)
    assert load(act, SMALL).policy.rate == 10
    assert not list(act.glob("threewe-*"))


def test_it_drives(act: Path) -> None:
    async def drive() -> str:
        async with Robot(image_size=(32, 32)) as robot:
            return (await load(act, SMALL).run(robot, timeout=1.0)).reason

    assert asyncio.run(drive()) in ("timeout", "reached")


def test_degrees_are_converted(act: Path) -> None:
    radians = load(act, SMALL)
    degrees = VLARunner.from_pretrained(act, rate=10, rename={"action": ["x.vel", "y.vel", "theta.vel"], STATE: NAMES})
    image = np.zeros((32, 32, 3), np.uint8)
    first, second = (each.predict(image, velocity=Velocity()) for each in (radians, degrees))
    assert second == pytest.approx(first * [1, 1, np.pi / 180])


NUMBERS = {"action": NAMES, STATE: NAMES}
MISMATCHES: list[tuple[dict[str, Any], str]] = [
    (
        {"rate": 10},
        r"state has 3 numbers and no names; action has 3 numbers and no names\. A robot of 3we has vx \[m/s\], "
        r".*rename=\{'observation\.state': \['vx', 'vy', 'omega'\], 'action': ",
    ),
    ({"rename": NUMBERS}, "says no rate: pass rate="),
    ({"rate": 10, "rename": {**NUMBERS, STATE: ["vx", "omega"]}}, r"state has 3 numbers and 2 names \(vx, omega\)"),
    (
        {"rate": 10, "rename": {**NUMBERS, "action": ["vx", "vy", "third"]}},
        r"action is \(vx, vy, third\); not known: third",
    ),
    (
        {"rate": 10, "rename": {**NUMBERS, STATE: ["x", "y", "theta"]}},
        r"not known: x, y, theta; where a robot stands is of its own map: train without \(--policy\.input_features\)",
    ),
    ({"rate": 10, "rename": {**NUMBERS, "action": ["vx", "vx", "omega"]}}, "one of them stands twice"),
    (
        {"rate": 10, "rename": {**NUMBERS, "rear": "camera"}},
        r"rename: the policy has no 'rear'; it has action, observation\.images\.camera",
    ),
    (
        {"rate": 10, "rename": {**NUMBERS, "camera": "my camera"}},
        r"camera 'my camera'.*rename=\{'observation\.images\.camera': 'camera'\}",
    ),
]


@pytest.mark.parametrize(("options", "message"), MISMATCHES)
def test_names_are_matched_never_guessed(act: Path, options: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message) as refusal:
        VLARunner.from_pretrained(act, **options)
    assert str(act / "config.json") in str(refusal.value)


def test_a_dataset_has_names_and_rate_and_the_robots_kinematics(act: Path, tmp_path: Path) -> None:
    names = {key: {"dtype": "float32", "shape": [3], "names": NAMES} for key in ("action", STATE)}
    for robot in ("3we_standard_v2", "turtlebot_like"):
        with DatasetWriter(tmp_path / robot, fps=20, features=names, robot_type=robot) as writer:
            writer.add_episode({key: np.zeros((4, 3), np.float32) for key in names}, "drive", {})
    policy = VLARunner.from_pretrained(act, dataset=tmp_path / "3we_standard_v2").policy
    assert (policy.rate, policy.kinematics.name, [each.name for each in policy.state]) == (20, "holonomic", NAMES)
    with pytest.raises(ConfigError, match=r"action has 'vy'; turtlebot_like, .* has a differential base"):
        VLARunner.from_pretrained(act, dataset=tmp_path / "turtlebot_like")
    with pytest.raises(ConfigError, match=r"rate=10 Hz, and its dataset .* has 20 Hz: leave rate= out"):
        VLARunner.from_pretrained(act, dataset=tmp_path / "3we_standard_v2", rate=10)


def test_states_that_no_robot_has_cannot_be_renamed(tmp_path: Path) -> None:
    folder = act_checkpoints.write(tmp_path / "act", Shape(32, 32, state=6, text=False))
    with pytest.raises(ConfigError, match=r"state has 6 numbers and no names.*; rename= cannot fix that"):
        VLARunner.from_pretrained(folder, rate=10, rename={"action": NAMES})


def test_a_camera_of_another_name_is_one_error_with_both_sides(tmp_path: Path) -> None:
    shape = Shape(32, 32, cameras=("front",), state=0, text=False)
    folder = act_checkpoints.write(tmp_path / "act", shape)

    async def drive(**rename: Any) -> str:
        runner = VLARunner.from_pretrained(folder, rate=10, rename={"action": NAMES, **rename})
        async with Robot(image_size=(32, 32)) as robot:
            return (await runner.run(robot, timeout=0.5)).reason

    with pytest.raises(
        ContractError,
        match=r'cameras: the policy takes front; 3we_standard_v2 has camera: .*rename=\{"front": "camera"\}',
    ):
        asyncio.run(drive())
    assert asyncio.run(drive(front="camera")) in ("timeout", "reached")


def test_arguments_of_other_types_and_formats(act: Path, tmp_path: Path) -> None:
    from ai import policies

    with pytest.raises(ContractError, match="rename must be a mapping"):
        VLARunner.from_pretrained(act, rename=["vx"])  # type: ignore[arg-type]
    with pytest.raises(ContractError, match="names are texts"):
        VLARunner.from_pretrained(act, rename={"action": [1, 2]})  # type: ignore[dict-item]
    with pytest.raises(ContractError, match=r"rate must be a number in \[0\.5, 50\] Hz, got True"):
        VLARunner.from_pretrained(act, rate=True)
    ours = policies.write(tmp_path / "ours")
    with pytest.raises(ConfigError, match=r"policy\.json says everything: leave out rate="):
        VLARunner.from_pretrained(ours, rate=10)


def edited(name: str, change: Callable[[dict[str, Any]], object]) -> Callable[[Path], None]:
    def edit(folder: Path) -> None:
        content = json.loads((folder / name).read_text())
        change(content)
        (folder / name).write_text(json.dumps(content))

    return edit


def retensored(change: Callable[[dict[str, Any]], object]) -> Callable[[Path], None]:
    def edit(folder: Path) -> None:
        weights = load_file(str(folder / "model.safetensors"))
        change(weights)
        save_file(weights, str(folder / "model.safetensors"))

    return edit


def claimed(folder: Path) -> None:
    """A header that says 2**60 numbers."""
    header = json.dumps(
        {"model.action_head.bias": {"dtype": "F32", "shape": [2**60], "data_offsets": [0, 2**62]}}
    ).encode()
    (folder / "model.safetensors").write_bytes(len(header).to_bytes(8, "little") + header)


def config(**changes: Any) -> Callable[[Path], None]:
    return edited("config.json", lambda content: content.update(changes))


BEFORE, AFTER = "policy_preprocessor.json", "policy_postprocessor.json"
HEAD = "model.action_head.bias"
NORMALIZER = "policy_preprocessor_step_3_normalizer_processor.safetensors"
HOSTILE: list[tuple[str, Callable[[Path], object], str]] = [
    (
        "class",
        edited(BEFORE, lambda c: c["steps"].append({"class": "os.system", "config": {"command": "touch run"}})),
        r"policy_preprocessor\.json: steps\[4\]\.class: 'os\.system' would be imported",
    ),
    (
        "class_after",
        edited(AFTER, lambda c: c["steps"][0].update({"class": "pty.spawn"})),
        r"policy_postprocessor\.json: steps\[0\]\.class",
    ),
    (
        "step",
        edited(BEFORE, lambda c: c["steps"][0].update(registry_name="evil")),
        r"steps\[0\]\.registry_name: must be one of",
    ),
    ("extra", edited(BEFORE, lambda c: c["steps"][0].update(more=1)), r"steps\[0\]\.more: is not a field"),
    (
        "state_path",
        edited(BEFORE, lambda c: c["steps"][3].update(state_file="../../x.safetensors")),
        r"steps\[3\]\.state_file: must be the name",
    ),
    (
        "mode",
        edited(AFTER, lambda c: c["steps"][0]["config"]["norm_map"].update(ACTION="SQUARE")),
        r"norm_map\.ACTION: must be one of",
    ),
    ("float16", edited(BEFORE, lambda c: c["steps"][2]["config"].update(float_dtype="float16")), r"float_dtype"),
    ("no_steps", edited(BEFORE, lambda c: c.pop("steps")), "steps: is missing"),
    ("kind", config(type="diffusion"), "type: 'diffusion' is not translated.*python="),
    ("no_kind", config(type=3), "type: must be the name"),
    ("peft", config(use_peft=True), "use_peft"),
    ("backbone", config(vision_backbone="resnet18; rm"), "vision_backbone: must be one of resnet18, resnet34"),
    ("width", config(dim_model=2**40), "dim_model: must be a whole number"),
    ("heads", config(n_heads=3), "no multiple of n_heads"),
    ("chunk", config(chunk_size=9), r"model\.decoder_pos_embed\.weight: is F32 8x32; expected F32 9x32"),
    ("activation", config(feedforward_activation="glu"), "feedforward_activation: 'glu'"),
    ("dilation", config(replace_final_stride_with_dilation=1), "replace_final_stride_with_dilation"),
    ("steps", config(n_obs_steps=2), "n_obs_steps"),
    ("layers", config(n_encoder_layers=2), r"model\.encoder\.layers\.1\.[\w.]+: is missing"),
    ("features", config(input_features=[]), "input_features: must be an object"),
    (
        "blind",
        config(input_features={STATE: {"type": "STATE", "shape": [3]}}),
        "0 cameras; a policy here acts on 1 to 4",
    ),
    (
        "wide",
        edited("config.json", lambda c: c["input_features"]["observation.images.camera"].update(shape=[3, 2**20, 8])),
        "shape: must be a list of 3 lengths",
    ),
    (
        "text",
        edited("config.json", lambda c: c["input_features"].update({TEXT: {"type": "ENV", "shape": [63]}})),
        "environment_state has 63 numbers; 3we gives the 64",
    ),
    (
        "other",
        edited(
            "config.json", lambda c: c["input_features"].update({"observation.force": {"type": "STATE", "shape": [6]}})
        ),
        r"input_features\.observation\.force",
    ),
    ("bomb", lambda folder: (folder / "config.json").write_text("[" * 100_000), r"config\.json: no JSON"),
    ("nan", retensored(lambda w: w[HEAD].fill(np.nan)), rf"model\.safetensors: {HEAD}: NaN or infinite"),
    ("missing", retensored(lambda w: w.pop(HEAD)), f"{HEAD}: is missing; expected 3"),
    ("more", retensored(lambda w: w.update(extra=np.zeros(3, np.float32))), "extra: is not a tensor of this network"),
    (
        "old",
        retensored(lambda w: w.update({"normalize_inputs.mean": np.zeros(3, np.float32)})),
        "written before LeRobot 0.4",
    ),
    ("shape", retensored(lambda w: w.update({HEAD: np.zeros(4, np.float32)})), f"{HEAD}: is F32 4; expected F32 3"),
    ("type", retensored(lambda w: w.update({HEAD: np.zeros(3, np.float64)})), f"{HEAD}: is F64 3; expected F32 3"),
    (
        "variance",
        retensored(lambda w: w["model.backbone.bn1.running_var"].fill(-1)),
        "running_var: a variance below zero",
    ),
    ("claimed", claimed, r"model\.safetensors: no safetensors"),
    ("cut", lambda folder: (folder / "model.safetensors").write_bytes(b"\0" * 20), "no safetensors"),
    ("no_weights", lambda folder: (folder / "model.safetensors").unlink(), r"model\.safetensors: no such file"),
    ("no_processor", lambda folder: (folder / AFTER).unlink(), r"policy_postprocessor\.json: no such file"),
    ("statistics", lambda folder: (folder / NORMALIZER).unlink(), rf"{NORMALIZER}: no such file"),
    ("pickle", lambda folder: (folder / "optimizer.pt").write_bytes(b""), r"optimizer\.pt: pickled"),
    (
        "deep",
        lambda folder: [(folder / "sub").mkdir(), (folder / "sub/x").write_bytes(b"PK\x03\x04")],
        "sub/x: pickled",
    ),
    ("gzip", lambda folder: (folder / "notes").write_bytes(b"\x1f\x8b\x08"), "notes: pickled"),
]


@pytest.mark.parametrize(("change", "message"), [h[1:] for h in HOSTILE], ids=[h[0] for h in HOSTILE])
def test_what_is_wrong_or_would_run_is_refused_with_file_and_field(
    act: Path, change: Callable[[Path], object], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(act.parent)
    change(act)
    with pytest.raises(ConfigError, match=message) as refusal:
        load(act, SMALL)
    assert str(act) in str(refusal.value)
    assert [path.name for path in act.parent.iterdir()] == ["act"]
    assert not list(act.glob("threewe-*"))


def test_safetensors_whose_length_looks_like_pickle_are_read(act: Path) -> None:
    file = act / NORMALIZER
    content = file.read_bytes()
    length = int.from_bytes(content[:8], "little")
    padded = 0x0480 + 0x10000  # its first bytes are 80 04
    header = content[8 : 8 + length] + b" " * (padded - length)
    file.write_bytes(padded.to_bytes(8, "little") + header + content[8 + length :])
    assert file.read_bytes()[:2] == b"\x80\x04"
    load(act, SMALL)


def test_a_kept_translation_is_checked_like_any_other(act: Path) -> None:
    load(act, SMALL)
    (kept,) = act.glob("threewe-*")
    (kept / "model.onnx").write_bytes(b"\xff" * 100)
    with pytest.raises(ConfigError, match=r"threewe-\w+/model\.onnx: no ONNX graph"):
        load(act, SMALL)


def test_an_exact_twin_is_the_twin(made: Path) -> None:
    (observation,) = act_checkpoints.observations(SMALL, 1, seed=1)
    twin = TwinPolicy(made)
    single = twin.predict(observation)
    assert twin.exact().predict(observation) == pytest.approx(single, abs=1e-5)
    assert torch.get_default_dtype() == torch.float32
