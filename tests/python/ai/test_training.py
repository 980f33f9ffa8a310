"""From demonstrations to a policy that drives, by the commands that users type."""

from __future__ import annotations

import asyncio
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from ai import policies
from numpy.typing import NDArray
from threewe import ConfigError, Kinematics, Robot, Velocity
from threewe._core import instruction_embedding
from threewe.ai import CameraInput, Policy, Quantity, VLARunner, read_policy
from threewe.ai.demonstrations import Demonstrations, demonstrations
from threewe.ai.serving import PolicyServer
from threewe.cli import app
from threewe.data.lerobot import Dataset
from typer.testing import CliRunner


def threewe(*arguments: str) -> str:
    result = CliRunner().invoke(app, arguments)
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.output


@pytest.fixture(scope="module")
def demos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("collected") / "demos"
    said = threewe("data", "collect", "--episodes", "4", "--scene", "office_v2", "-o", str(folder))
    assert "of 4 arrived" in said
    return folder


def test_demonstrations_say_what_is_to_be_done(demos: Path) -> None:
    dataset = Dataset.open(demos)
    assert len(dataset) == 4
    assert all(task.startswith("go to the ") for task in dataset.tasks)
    columns = dataset.episodes[0].columns()
    embedding = columns["observation.environment_state"]
    assert embedding.shape == (len(dataset.episodes[0]), 64)
    assert np.linalg.norm(embedding, axis=1) == pytest.approx(1.0)
    assert dataset.episodes[0].video("observation.images.camera").shape == (60, 80, 3)
    assert not columns["action"][-2:].any()  # the robot stands in the end


def test_what_pushed_the_robot_is_no_target(demos: Path) -> None:
    dataset = Dataset.open(demos)
    columns = [episode.columns() for episode in dataset.episodes]
    pushed = [c["disturbed"].ravel() for c in columns if c["next.success"].any()]
    assert any(each.any() for each in pushed)
    wanted = demonstrations([dataset], 10).wanted
    begin = 0
    for each in pushed:
        shown = wanted[begin : begin + len(each)]
        for row in range(1, len(each)):  # a picture is a row older than the row that shows it
            for k in range(10):
                assert shown[row, k] == (not each[row - 1 : row + k].any())
        begin += len(each)
    assert begin == len(wanted)


def collected(folder: Path, *options: str) -> list[dict[str, Any]]:
    """The columns of two drives."""
    threewe("data", "collect", "--episodes", "2", "--scene", "apartment_v1", *options, "-o", str(folder))
    return [episode.columns() for episode in Dataset.open(folder).episodes]


def test_demonstrations_without_bursts(tmp_path: Path) -> None:
    drives = collected(tmp_path / "demos", "--disturbance", "none")
    assert not any(drive["disturbed"].any() for drive in drives)


def test_the_teacher_goes_on_from_where_a_policy_went(tmp_path: Path) -> None:
    """One that turns to the left all the time, which the navigator does not."""
    policy = policies.write(tmp_path / "policy", policies.graph((0.0, 0.0, 0.5)))
    drives = collected(tmp_path / "demos", "--disturbance", str(policy), "--seed", "4")
    assert all(drive["next.success"].any() for drive in drives)
    disturbed = np.concatenate([drive["disturbed"].ravel() for drive in drives])
    turning = np.isclose(np.concatenate([drive["action"][:, 2] for drive in drives]), 0.5, atol=1e-3)
    assert turning[disturbed].mean() > 0.9
    assert turning[~disturbed].mean() < 0.1


@pytest.mark.parametrize(
    ("disturbance", "teacher", "error"),
    [("goto_v1", "instruction", "disturbance: goto_v1"), ("missing", "navigator", "missing: no such folder")],
)
def test_a_policy_that_cannot_disturb(tmp_path: Path, disturbance: str, teacher: str, error: str) -> None:
    with pytest.raises(ConfigError, match=error):
        threewe("data", "collect", "--disturbance", disturbance, "--teacher", teacher, "-o", str(tmp_path / "demos"))
    assert not (tmp_path / "demos").exists()


@pytest.mark.parametrize(
    ("task", "teacher"),
    [
        ("objectnav", "navigator"),
        ("vln", "navigator"),
        pytest.param("goto", "instruction", marks=pytest.mark.nightly),
        pytest.param("objectnav", "instruction", marks=pytest.mark.nightly),
        ("vln", "instruction"),
    ],
)
def test_demonstrations_of_other_tasks_and_of_the_other_teacher(tmp_path: Path, task: str, teacher: str) -> None:
    folder = tmp_path / "demos"
    how = ("--task", task, "--teacher", teacher, "--scene", "apartment_v1", "--seed", "1")
    said = threewe("data", "collect", *how, "--episodes", "2", "-o", str(folder))
    dataset = Dataset.open(folder)
    assert len(dataset) == 2
    ways = [text for text in dataset.tasks if not text.startswith("go to the ")]
    assert bool(ways) == (task == "vln"), dataset.tasks
    columns = [episode.columns() for episode in dataset.episodes]
    arrived = sum(bool(each["next.success"].any()) for each in columns)
    assert f"{arrived} of 2 arrived ({task}, {teacher})" in said
    assert arrived == 2 or teacher == "instruction"
    for episode, each in zip(dataset.episodes, columns, strict=True):
        driven = np.ptp(each["observation.state"][:, :2], axis=0).max()
        assert driven > 0.3, driven
        assert not each["action"][-2:].any()  # the robot stands in the end
        height = {"navigator": 60, "instruction": 240}[teacher]
        assert episode.video("observation.images.camera").shape[0] == height
    if teacher == "instruction":
        assert not any(each["disturbed"].any() for each in columns)


def test_training_makes_a_policy_that_drives(demos: Path, tmp_path: Path) -> None:
    folder = tmp_path / "policy"
    losses = [
        float(line.split("loss ")[1].split(",")[0])
        for line in threewe(
            "policy", "train", str(demos), "-o", str(folder), "--passes", "3", "--checks", "0"
        ).splitlines()
        if "loss" in line
    ]
    assert losses[-1] < losses[0]
    policy = read_policy(folder)
    assert (policy.chunk, policy.rate, policy.language) == (10, 10.0, True)
    assert (folder / "model.onnx").stat().st_size < 2e6
    assert "60 x 80, rgb" in threewe("policy", "info", str(folder))
    assert "Hz, on one thread" in threewe("policy", "bench", str(folder), "--count", "5")
    eight = str(tmp_path / "eight")
    threewe("policy", "export", str(folder), "--int8", "--dataset", str(demos), "--count", "20", "-o", eight)
    assert read_policy(eight).training["int8"] == "ranges by 20 observations"

    async def drive() -> str:
        async with Robot(image_size=(60, 80), seed=5) as robot:
            return (await VLARunner(policy).run(robot, "go to the chair", timeout=3.0)).reason

    assert asyncio.run(drive()) in ("reached", "timeout")
    with pytest.raises(ConfigError, match="exists already"):
        threewe("policy", "train", str(demos), "-o", str(folder))
    curve = np.genfromtxt(folder / "losses.csv", delimiter=",", names=True)
    assert np.isfinite(curve["train"]).all()
    assert (np.diff(curve["step"]) > 0).all()
    assert np.isfinite(curve["held_out"]).sum() == 0  # four episodes are too few to hold one out
    assert not (tmp_path / "policy.training").exists()


def test_a_training_that_was_cut_off_goes_on_to_the_same_policy(
    demos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from threewe.ai import training

    def train(output: Path, *options: str) -> str:
        how = ("--passes", "3", "--checks", "1", "--prefix", *options)
        return threewe("policy", "train", str(demos), "-o", str(output), *how)

    assert train(tmp_path / "whole").count("in 1 generated buildings") == 2  # after the later passes
    learn = training.Learner.learn

    def cut_off(learner: training.Learner) -> str:
        if learner.done == 2:
            raise RuntimeError("cut off")
        return learn(learner)

    monkeypatch.setattr(training.Learner, "learn", cut_off)
    cut = tmp_path / "cut"
    with pytest.raises(RuntimeError, match="cut off"):
        train(cut)
    monkeypatch.setattr(training.Learner, "learn", learn)
    assert not cut.exists()
    assert sorted(file.name for file in (tmp_path / "cut.training").iterdir()) == ["losses.csv", "state.safetensors"]
    with pytest.raises(ConfigError, match="--resume goes on with it"):
        train(cut)
    with pytest.raises(ConfigError, match=r"'passes': 3.*'passes': 5"):
        threewe("policy", "train", str(demos), "-o", str(cut), "--passes", "5", "--checks", "1", "--prefix", "--resume")
    assert "pass 3 of 3" in (said := train(cut, "--resume"))
    assert "pass 2 of 3: loss" not in said
    for file in ("model.onnx", "policy.json", "losses.csv"):
        assert (cut / file).read_bytes() == (tmp_path / "whole" / file).read_bytes(), file
    with pytest.raises(ConfigError, match="is not there"):
        train(tmp_path / "new", "--resume")
    (tmp_path / "new.training").mkdir()
    (tmp_path / "new.training/state.safetensors").write_bytes(b"\x80\x04pickled")
    with pytest.raises(ConfigError, match="no training that can go on"):
        train(tmp_path / "new", "--resume")


@pytest.mark.parametrize(
    ("names", "columns"),
    [
        (["vx.vel", "vy.vel", "omega.vel"], ["vx", "vy", "omega"]),
        (["x.vel", "y.vel", "theta.vel"], ["vx", "vy", "omega"]),
        (["vx.vel", "omega.vel"], ["vx", "omega"]),
    ],
)
def test_learning_from_a_dataset_that_lerobot_recorded(tmp_path: Path, names: list[str], columns: list[str]) -> None:
    """It has LeRobot's names, no embedding, no success, and a robot that is none of our profiles."""
    from threewe.ai.demonstrations import demonstrations
    from threewe.data.lerobot import ArrayFrames, DatasetWriter

    random = np.random.default_rng(1)
    velocity = {"dtype": "float32", "shape": (len(names),), "names": names}
    picture = {"dtype": "video", "shape": (60, 80, 3), "names": ["height", "width", "channels"]}
    features = {"action": velocity, "observation.state": velocity, "observation.images.camera": picture}
    drives = [random.uniform(-0.5, 0.5, (30, len(names))).astype(np.float32) for _ in range(2)]
    tasks = ["go to the chair", "go to the couch"]
    with DatasetWriter(tmp_path / "theirs", fps=10, features=features, robot_type="threewe") as writer:
        for drive, task in zip(drives, tasks, strict=True):
            frames = ArrayFrames(random.integers(0, 256, (30, 60, 80, 3), np.uint8))
            writer.add_episode(
                {"action": drive, "observation.state": drive}, [task] * 30, {"observation.images.camera": frames}
            )
    data = demonstrations([Dataset.open(tmp_path / "theirs")], 10)
    scale = [np.pi / 180 if name == "theta.vel" else 1.0 for name in names]
    assert data.actions[1, 0] == pytest.approx(drives[0][0] * scale)  # a picture is a row older than the row shows it
    assert data.embeddings[0] == pytest.approx(instruction_embedding(tasks[0]))
    assert data.embeddings[-1] == pytest.approx(instruction_embedding(tasks[1]))
    folder = tmp_path / "policy"
    said = threewe("policy", "train", str(tmp_path / "theirs"), "-o", str(folder), "--passes", "1", "--checks", "1")
    assert ("no drives in generated buildings" in said) == (
        len(names) == 2
    )  # in generated buildings a holonomic robot drives
    policy = read_policy(folder)
    assert [each.name for each in policy.action] == columns
    assert policy.kinematics is (Kinematics.holonomic if len(names) == 3 else Kinematics.differential)


@pytest.mark.nightly  # with 2,000 demonstrations: ./dev verify policies
def test_64_demonstrations_teach_more_than_a_constant(tmp_path: Path) -> None:
    """Of the episodes that training holds out: its loss falls, and is below that of the mean action."""
    demos, folder = tmp_path / "demos", tmp_path / "policy"
    threewe("data", "collect", "--episodes", "64", "--scene", "apartment_v1", "-o", str(demos))
    said = threewe("policy", "train", str(demos), "-o", str(folder), "--passes", "4", "--checks", "0")
    losses = [float(line.rpartition("held out ")[2]) for line in said.splitlines() if "held out " in line]
    policy, data = read_policy(folder), demonstrations([Dataset.open(demos)], 10)
    mean, std = (np.array([getattr(each, name) for each in policy.action]) for name in ("mean", "std"))
    off = np.abs((data.actions[data.held_out] - mean) / std)[data.wanted[data.held_out]]
    constant = np.where(off < 1, off**2 / 2, off - 0.5).mean()
    print(f"of {len(data.held_out)} rows: {losses} held out, {constant:.3f} by a constant")
    assert losses[-1] < losses[0]
    assert losses[-1] < 0.9 * constant


def test_an_act_is_in_lerobots_format_and_in_ours(demos: Path, tmp_path: Path) -> None:
    folder = tmp_path / "act"
    said = threewe("policy", "train", str(demos), "-o", str(folder), "--passes", "2", "--checks", "0", "--model", "act")
    losses = [float(line.split("loss ")[1].split(",")[0]) for line in said.splitlines() if "loss" in line]
    assert losses[-1] < losses[0]
    ours = VLARunner.from_pretrained(folder)
    assert (ours.policy.chunk, ours.policy.merge, ours.policy.language) == (10, "blend", True)
    (folder / "policy.json").unlink()  # and it is a checkpoint of LeRobot's
    theirs = VLARunner.from_pretrained(folder, dataset=demos)
    assert theirs.policy.training["kind"] == "act"
    picture = np.random.default_rng(1).integers(0, 256, (60, 80, 3), np.uint8)
    actions = [runner.predict_chunk(picture, "go to the chair") for runner in (ours, theirs)]
    np.testing.assert_array_equal(*actions)


def test_the_network_of_an_act_is_the_obvious_one() -> None:
    from threewe.ai.act_network import ActNetwork

    from verify.cases.act_checkpoints import Shape, Twin

    torch.manual_seed(3)
    network = ActNetwork(8, 3, np.zeros(3, np.float32), np.ones(3, np.float32)).eval()
    state = network.state_dict()
    for name, values in state.items():
        if "running_mean" in name or name.endswith(("conv2.weight", "bn1.bias", "bn2.bias")):
            values.copy_(0.05 * torch.randn_like(values))
        elif "running_var" in name:
            values.copy_(0.5 + torch.rand_like(values))
    sizes = {"dim_model": 128, "n_heads": 4, "dim_feedforward": 256, "latent_dim": 32}
    twin = Twin(Shape(60, 80, state=0, options=sizes).config())
    twin.load_state_dict(state)
    pictures, embeddings = torch.rand(5, 3, 60, 80), torch.randn(5, 64)
    with torch.no_grad():
        found = network(pictures, embeddings)
        for i in range(5):
            observation = {
                "observation.images.camera": pictures[i : i + 1],
                "observation.environment_state": embeddings[i : i + 1],
            }
            np.testing.assert_allclose(found[i].numpy(), twin(observation).numpy(), rtol=0, atol=1e-5)


@pytest.mark.parametrize("prefix", [0, 4])
def test_the_graph_computes_what_the_network_does(tmp_path: Path, prefix: int) -> None:
    from threewe.ai.folder import write_policy
    from threewe.ai.network import Network, to_onnx

    read = read_policy(policies.write(tmp_path / "like"))
    torch.manual_seed(3)
    read = replace(read, prefix=prefix)
    network = Network(policies.HEIGHT, policies.WIDTH, policies.CHUNK, 3, prefix).eval()
    assert sum(each.numel() for each in network.parameters()) <= 500_000
    folder = tmp_path / "policy"
    write_policy(policies.moved(read, folder), to_onnx(network, read))
    runner = VLARunner.from_pretrained(folder)
    random = np.random.default_rng(1)
    for _ in range(20):
        picture = random.integers(0, 256, (policies.HEIGHT, policies.WIDTH, 3), np.uint8)
        rgb = torch.from_numpy(picture[:, :, ::-1].copy()).permute(2, 0, 1)[None].float() / 255
        committed = [Velocity(*random.normal(size=3)) for _ in range(prefix)]
        given = [torch.tensor([[[*each, 1.0] for each in committed]])] if prefix else []
        with torch.no_grad():
            expected = network(rgb, torch.from_numpy(runner._embedding("go to the chair")), *given)[0].numpy()
        feed = runner._feed(picture, "go to the chair", None, committed)
        assert runner._actions(runner._engine.infer(feed, "")) == pytest.approx(expected, abs=1e-5)


def drives_of(pictures: NDArray[np.uint8], velocities: NDArray[np.float32]) -> Demonstrations:
    """Pictures with the velocity that each of six actions has."""
    rows = len(pictures)
    embeddings, wanted = np.zeros((rows, 64), np.float32), np.ones((rows, 6), np.bool_)
    return Demonstrations(pictures, embeddings, np.repeat(velocities, 6, 1), wanted, np.arange(rows) % 10 == 0)


def learnt(data: Demonstrations, prefix: int = 0, mirror: bool = False) -> torch.nn.Module:
    """A network after twelve passes."""
    from threewe.ai.training import Learner

    action = tuple(Quantity(name, "rad/s" if name == "omega" else "m/s", 0.0, 1.0) for name in ("vx", "vy", "omega"))
    camera = (CameraInput("camera", 16, 16, "rgb"),)
    policy = Policy(
        Path("none"), Kinematics.holonomic, camera, (), action, 10.0, 6, 0.1, "replace", True, {}, None, prefix
    )
    learner = Learner(data, policy, 12, 1, "film", 64, torch.device("cpu"), mirror)
    for _ in range(12):
        learner.learn()
    return learner.network


@pytest.mark.parametrize("mirror", [False, True])
def test_what_is_learnt_of_one_side_holds_for_the_other_by_a_mirror(mirror: bool) -> None:
    """What is bright is always on the left, and the robot goes there."""
    random = np.random.default_rng(2)
    pictures = random.integers(0, 100, (512, 16, 16, 3), np.uint8)
    pictures[:, :, :8] += 150
    network = learnt(drives_of(pictures, np.tile(np.array([0.3, 0.4, 0.8], np.float32), (512, 1, 1))), mirror=mirror)
    for side, shown in ((1, pictures), (-1, np.flip(pictures, 2))):
        lights = torch.from_numpy(shown[:50].copy()).permute(0, 3, 1, 2).float() / 255
        with torch.no_grad():
            vx, vy, omega = network(lights, torch.zeros(50, 64)).mean((0, 1)).tolist()
        to = side if mirror else 1
        assert (vx, vy, omega) == pytest.approx((0.3, 0.4 * to, 0.8 * to), abs=0.2)


def test_a_network_learns_to_go_on_from_what_is_committed() -> None:
    """Each drive has a speed that no picture shows: without a prefix the network gives their mean."""
    random = np.random.default_rng(1)
    rows = 1024
    speeds = random.normal(0.0, 1.0, (rows, 1, 3)).astype(np.float32)
    data = drives_of(random.integers(0, 256, (rows, 16, 16, 3), np.uint8), speeds)
    network = learnt(data, prefix=3)
    held = np.flatnonzero(data.held_out)
    pictures = torch.from_numpy(data.pictures[held]).permute(0, 3, 1, 2).float() / 255
    texts = torch.from_numpy(data.embeddings[held])
    seams = []
    for count in (0, 2):
        prefix = torch.zeros(len(held), 3, 4)
        prefix[:, :count, :3] = torch.from_numpy(data.actions[held, :count])
        prefix[:, :count, 3] = 1
        with torch.no_grad():
            free = network(pictures, texts, prefix)[:, count]
        seams.append(float((free - torch.from_numpy(speeds[held, 0])).abs().mean()))
    assert seams[1] < 0.5 * seams[0]


def test_a_policy_with_a_prefix_is_trained_by_the_command(demos: Path, tmp_path: Path) -> None:
    folder = tmp_path / "policy"
    threewe("policy", "train", str(demos), "-o", str(folder), "--passes", "1", "--checks", "0", "--prefix")
    policy = read_policy(folder)
    assert (policy.prefix, policy.merge) == (4, "replace")
    assert "first 4 actions" in threewe("policy", "info", str(folder))

    async def drive() -> str:
        async with Robot(image_size=(60, 80), seed=5) as robot:
            return (await VLARunner(policy).run(robot, "go to the chair", timeout=2.0)).reason

    assert asyncio.run(drive()) in ("reached", "timeout")
    eight = str(tmp_path / "eight")
    threewe("policy", "export", str(folder), "--int8", "--dataset", str(demos), "--count", "20", "-o", eight)
    with PolicyServer(VLARunner.from_pretrained(eight)) as server:
        far, near = VLARunner.from_pretrained(server.address), VLARunner.from_pretrained(eight)
        picture = np.zeros((60, 80, 3), np.uint8)
        committed, text = [Velocity(0.3, 0.0, 0.1)] * 3, "go to the chair"
        mean, std = (np.array([getattr(q, name) for q in policy.action]) for name in ("mean", "std"))
        chunks = [
            runner._engine.infer(runner._feed(picture, text, None, committed), text)[0, 3:] * scale + offset
            for runner, scale, offset in ((far, 1.0, 0.0), (near, std, mean))
        ]
    assert chunks[0] == pytest.approx(chunks[1], abs=1e-5)
    with pytest.raises(ConfigError, match="prefix: LeRobot's ACT takes none"):
        threewe("policy", "train", str(demos), "-o", str(tmp_path / "act"), "--prefix", "--model", "act")


def test_datasets_that_cannot_be_learnt_from(demos: Path, tmp_path: Path) -> None:
    from threewe.ai.training import train_policy

    def train(dataset: Path) -> None:
        train_policy([dataset], tmp_path / "policy", 1, 0, 0, print)

    with pytest.raises(ConfigError, match="no LeRobot dataset"):
        train(tmp_path)
    info = json.loads((demos / "meta/info.json").read_text())
    picture, text = "observation.images.camera", "observation.environment_state"
    for feature, change, message in (
        (picture, None, "no 'observation.images.camera'; there are action"),
        (text, {"shape": [16]}, r"shape \(16,\); expected the 64 numbers"),
        ("action", {"names": ["arm.pos", "vx", "omega"]}, r"action is \(arm.pos, vx, omega\); expected vx"),
        ("action", {"names": ["vx", "x.vel", "omega"]}, r"action is \(vx, x.vel, omega\); expected vx"),
    ):
        features = dict(info["features"])
        features[feature] = {**features[feature], **(change or {})}
        if change is None:
            del features[feature]
        broken = {**info, "features": features}
        copy = tmp_path / message
        (copy / "meta").mkdir(parents=True)
        for file in (demos / "meta").rglob("*"):
            if file.is_file():
                target = copy / file.relative_to(demos)
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(file.read_bytes())
        (copy / "meta/info.json").write_text(json.dumps(broken))
        with pytest.raises(ConfigError, match=message):
            train(copy)
    assert not (tmp_path / "policy").exists()
