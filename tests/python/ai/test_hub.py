"""Policies of the Hub: by name and revision, only what they consist of, and without network by what is kept."""

from __future__ import annotations

import types
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from ai import policies
from data.fake_hub import Hub, Repo, running
from huggingface_hub import constants
from threewe import ConfigError, ConnectionError
from threewe.ai import VLARunner
from threewe.cli import app
from typer.testing import CliRunner

from verify.cases import act_checkpoints

pytestmark = pytest.mark.filterwarnings("ignore:Use 'content=:DeprecationWarning")
ID = "user/fetch.me"
NAMES = {"rate": 10, "rename": {"action": ["vx", "vy", "omega"], "observation.state": ["vx", "vy", "omega"]}}


def content_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def hub(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Hub]:
    """A Hub with a policy in two commits, of which the first is tagged, without a login and with an empty cache."""
    monkeypatch.delenv("HF_TOKEN", raising=False)
    monkeypatch.delenv("HF_HUB_OFFLINE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(constants, "HF_TOKEN_PATH", str(tmp_path / "no_token"))
    without_sleep = types.SimpleNamespace(**{**vars(__import__("time")), "sleep": lambda _: None})
    monkeypatch.setattr("huggingface_hub.utils._http.time", without_sleep)
    monkeypatch.setattr("huggingface_hub.file_download.time", without_sleep)
    monkeypatch.chdir(tmp_path)
    with running(Hub()) as made:
        monkeypatch.setenv("HF_ENDPOINT", made.url)
        repo = made.repos[ID] = Repo()
        first = policies.write(tmp_path / "first", policies.graph((0.1, 0.0, 0.0)))
        repo.refs["v1"] = repo.commit({**content_of(first), "pickled.pkl": b"\x80\x04.", "sub/model.onnx": b"no"})
        repo.commit(content_of(policies.write(tmp_path / "second", policies.graph((0.2, 0.0, 0.0)))))
        yield made


def speed(runner: VLARunner) -> float:
    picture = np.zeros((policies.HEIGHT, policies.WIDTH, 3), np.uint8)
    return float(runner.predict(picture, "go to the chair")[0])


def test_a_policy_is_pulled_by_branch_tag_and_commit(hub: Hub, tmp_path: Path) -> None:
    assert speed(VLARunner.from_pretrained(ID)) == pytest.approx(0.2)
    assert speed(VLARunner.from_pretrained(ID, revision="v1")) == pytest.approx(0.1)
    commit = hub.repos[ID].refs["v1"]
    kept = tmp_path / "cache/threewe/policies/user--fetch.me" / commit
    assert {path.name for path in kept.iterdir()} == {"policy.json", "model.onnx"}
    assert not hub.count("pickled|sub/")

    asked = len(hub.requests)
    assert speed(VLARunner.from_pretrained(ID, revision=commit)) == pytest.approx(0.1)
    assert len(hub.requests) == asked  # a commit never changes


def test_a_checkpoint_of_lerobot_is_pulled_with_its_statistics(hub: Hub, tmp_path: Path) -> None:
    shape = act_checkpoints.Shape(32, 32)
    folder = act_checkpoints.write(tmp_path / "act", shape)
    hub.repos["user/act"] = Repo()
    hub.repos["user/act"].commit(content_of(folder))
    there, here = (VLARunner.from_pretrained(each, **NAMES) for each in ("user/act", folder))
    for given in act_checkpoints.observations(shape, 2, seed=1):
        np.testing.assert_array_equal(there._engine.infer(given, ""), here._engine.infer(given, ""))


@pytest.mark.usefixtures("hub")
def test_commands_take_policies_of_the_hub() -> None:
    def policy(*arguments: str) -> str:
        result = CliRunner().invoke(app, ["policy", *arguments])
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            raise result.exception
        return result.output

    assert "12 x 16, rgb" in policy("info", ID, "--revision", "v1")
    assert "Hz, on one thread" in policy("bench", ID, "--count", "5", "--revision", "v1")
    drive = ("run", ID, "--instruction", "go to the chair", "--seconds", "0.5", "--revision")
    assert ", 4 inferences" in policy(*drive, "v1")
    assert "generated" in policy("eval", ID, "--episodes", "generated", "--count", "1", "--revision", "v1")
    with pytest.raises(ConfigError, match="no such revision"):
        policy(*drive, "v2")
    with pytest.raises(ConfigError, match=r"user/fetch\.me: what is on the Hub is not written to"):
        policy("bench", ID, "--write")
    with pytest.raises(ConfigError, match="revision='v1' is of a repository of the Hub"):
        policy("info", "goto_v1", "--revision", "v1")


def test_without_network_the_error_says_what_to_type(hub: Hub, monkeypatch: pytest.MonkeyPatch) -> None:
    commit = hub.repos[ID].refs["v1"]
    VLARunner.from_pretrained(ID, revision="v1")
    monkeypatch.setenv("HF_ENDPOINT", "http://127.0.0.1:9")
    with pytest.raises(ConnectionError, match=r"hf download user/other --local-dir policy; then pass the folder"):
        VLARunner.from_pretrained("user/other")
    with pytest.raises(ConnectionError, match=rf"no connection to .*revision='{commit}' is kept here"):
        VLARunner.from_pretrained(ID)
    assert speed(VLARunner.from_pretrained(ID, revision=commit)) == pytest.approx(0.1)


def test_what_is_not_there_and_what_is_no_policy(hub: Hub, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"'user/fetch\.me' has no such revision"):
        VLARunner.from_pretrained(ID, revision="v2")
    with pytest.raises(ConfigError, match="user/none"):
        VLARunner.from_pretrained("user/none")
    hub.repos["user/torch"] = Repo()
    hub.repos["user/torch"].commit({"model.pt": b"PK\x03\x04"})
    with pytest.raises(ConfigError, match=r"'user/torch' is no policy: it has neither policy\.json nor config\.json"):
        VLARunner.from_pretrained("user/torch")
    with pytest.raises(ConfigError, match=r"revision='v1' is of a repository of the Hub"):
        VLARunner.from_pretrained(policies.write(tmp_path / "policy"), revision="v1")
    hub.spoil = lambda path, content: content[:-1] + b"!" if path == "model.onnx" else content
    with pytest.raises(ConfigError, match=r"model\.onnx of 'user/fetch\.me' did not arrive as the server announced"):
        VLARunner.from_pretrained(ID)


def test_lerobots_grpc_server_is_refused_with_the_reason() -> None:
    with pytest.raises(ConfigError, match=r"grpc://127\.0\.0\.1:8080: LeRobot's policy server unpickles.*ws://"):
        VLARunner.from_pretrained("grpc://127.0.0.1:8080")
