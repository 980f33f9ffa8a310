"""Datasets go to the Hub and come back: whole, with a card, and without the token ever being shown."""

from __future__ import annotations

import io
import logging
import os
import subprocess
import sys
import time
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from data.fake_hub import TOKEN, Hub, running
from data.tiny_dataset import CAMERA, HUES, write_tiny_dataset
from huggingface_hub import constants
from PIL import Image
from threewe import ConfigError, ConnectionError
from threewe.data.hub import pull, push

# `huggingface_hub` uses its HTTP client as one should not any more.
pytestmark = pytest.mark.filterwarnings("ignore:Use 'content=:DeprecationWarning")

REPO = "user/3we-office-nav"
VIDEO = f"videos/{CAMERA}/chunk-000/file-000.mp4"


@pytest.fixture
def hub(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Hub]:
    """A Hub that the user is logged in to."""
    monkeypatch.setenv("HF_TOKEN", TOKEN)
    monkeypatch.delenv("HF_HUB_OFFLINE", raising=False)
    monkeypatch.setattr(constants, "HF_TOKEN_PATH", str(tmp_path / "no_token"))
    # Retries wait for seconds; the tests do not.
    without_sleep = types.SimpleNamespace(**{**vars(time), "sleep": lambda _: None})
    monkeypatch.setattr("huggingface_hub.utils._http.time", without_sleep)
    monkeypatch.setattr("huggingface_hub.file_download.time", without_sleep)
    with running(Hub()) as made:
        monkeypatch.setenv("HF_ENDPOINT", made.url)
        yield made


@pytest.fixture
def dataset(tmp_path: Path) -> Path:
    return write_tiny_dataset(tmp_path / "my_dataset")


@pytest.fixture
def lfs(hub: Hub, monkeypatch: pytest.MonkeyPatch) -> Hub:
    """A Hub that keeps files of 1,000 bytes and more in its store of large files."""
    monkeypatch.setattr(constants, "HF_HUB_DISABLE_XET", True)
    hub.large = 1000
    return hub


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def run(*arguments: str, cwd: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """`threewe data ...` in a process of its own."""
    program = (
        "import typer, threewe.cli\n"
        "from threewe.data import cli_hub\n"
        "data = typer.Typer()\n"
        "data.command()(cli_hub.push)\n"
        "data.command()(cli_hub.pull)\n"
        "if not any(group.name == 'data' for group in threewe.cli.app.registered_groups):\n"
        "    threewe.cli.app.add_typer(data, name='data')\n"
        "threewe.cli.main()\n"
    )
    env = {**os.environ, "HF_HOME": str(cwd / "hf_home"), "COLUMNS": "200", **environment}
    return subprocess.run([sys.executable, "-c", program, *arguments], cwd=cwd, env=env, capture_output=True, text=True)


def test_a_dataset_goes_up_with_its_card_and_tag(hub: Hub, dataset: Path) -> None:
    assert push(dataset, REPO, license="cc-by-4.0") == f"{hub.url}/datasets/{REPO}"
    repo = hub.repos[REPO]
    for path, content in contents(dataset).items():
        assert repo.files[path] == content
    assert repo.refs["v3.0"] == repo.refs["main"]
    assert not repo.private
    text = repo.files["README.md"].decode()
    front = text.split("---")[1]
    for line in ("license: cc-by-4.0", "- LeRobot", "- 3we", "configs:", "  data_files: data/*/*.parquet"):
        assert line in front.splitlines()
    assert "| 3we\\_standard\\_v2 | 3 | 24 | 10 | 2 s |" in text
    assert "- go to the kitchen" in text
    assert f"| `{CAMERA}` | video | 48 x 64 x 3 |" in text
    assert "![Frames of the episodes](preview.jpg)" in text


def test_the_preview_shows_a_frame_of_each_episode(hub: Hub, dataset: Path) -> None:
    push(dataset, REPO)
    with Image.open(io.BytesIO(hub.repos[REPO].files["preview.jpg"])) as picture:
        pixels = np.asarray(picture.convert("RGB")).astype(int)
    for i, hue in enumerate(HUES):
        middle = pixels[pixels.shape[0] // 2, int((i + 0.5) * pixels.shape[1] / 3)]
        assert np.abs(middle - hue).max() < 30, (i, middle)


@pytest.mark.usefixtures("hub")
def test_it_comes_back_byte_by_byte(dataset: Path, tmp_path: Path) -> None:
    push(dataset, REPO)
    shares: list[float] = []
    folder = pull(REPO, tmp_path / "back", on_progress=shares.append)
    assert contents(dataset).items() <= contents(folder).items()
    assert set(contents(folder)) - set(contents(dataset)) == {"README.md", "preview.jpg"}
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["back", "my_dataset"]


def test_the_line_of_the_paper_works_literally_and_large_files_are_stored_apart(
    hub: Hub, dataset: Path, tmp_path: Path
) -> None:
    hub.large = 1000
    done = run(*f"data push my_dataset --repo-id {REPO}".split(), cwd=tmp_path, HF_HUB_DISABLE_XET="1")
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"pushed to {hub.url}/datasets/{REPO}\n"
    assert hub.objects
    assert (dataset / VIDEO).read_bytes() in hub.objects.values()
    assert hub.repos[REPO].files[VIDEO] == (dataset / VIDEO).read_bytes()
    done = run("data", "pull", REPO, "back", cwd=tmp_path, HF_HUB_DISABLE_XET="1")
    assert done.returncode == 0, done.stderr
    assert contents(dataset).items() <= contents(tmp_path / "back").items()


def test_pushing_again_sends_only_what_is_new_and_moves_the_tag(hub: Hub, dataset: Path) -> None:
    push(dataset, REPO)
    first = hub.repos[REPO].refs["v3.0"]
    push(dataset, REPO)
    assert hub.repos[REPO].refs["v3.0"] == first
    before = len(hub.repos[REPO].commits)
    (dataset / "meta/stats.json").write_text('{"action": {}}')
    push(dataset, REPO)
    assert len(hub.repos[REPO].commits) == before + 1
    assert hub.repos[REPO].refs["v3.0"] == hub.repos[REPO].refs["main"] != first


def test_files_that_are_gone_here_are_deleted_there_and_foreign_ones_stay_private(hub: Hub, dataset: Path) -> None:
    (dataset / "data/chunk-000/file-001.parquet").write_bytes(b"old")
    push(dataset, REPO)
    assert "data/chunk-000/file-001.parquet" in hub.repos[REPO].files
    (dataset / "data/chunk-000/file-001.parquet").unlink()
    (dataset / ".env").write_text("PASSWORD=1")
    (dataset / "journal").mkdir()
    (dataset / "journal/episode").write_text("not for others")
    push(dataset, REPO)
    names = set(hub.repos[REPO].files)
    assert names == {*contents(dataset), ".gitattributes", "README.md", "preview.jpg"} - {".env", "journal/episode"}


def test_an_own_card_stays_and_a_written_one_is_written_anew(hub: Hub, dataset: Path, tmp_path: Path) -> None:
    push(dataset, REPO)
    pulled = pull(REPO, tmp_path / "back")
    push(pulled, "user/other")
    assert b'LeRobotDataset("user/other")' in hub.repos["user/other"].files["README.md"]
    (pulled / "README.md").write_text("# Mine\n")
    push(pulled, REPO)
    assert hub.repos[REPO].files["README.md"] == b"# Mine\n"


def test_a_private_dataset_is_private_from_the_first_byte(hub: Hub, dataset: Path) -> None:
    push(dataset, REPO, private=True)
    assert hub.repos[REPO].private
    push(dataset, "user/public")
    before = dict(hub.repos["user/public"].commits)
    (dataset / "meta/stats.json").write_text('{"secret": {}}')
    with pytest.raises(ConfigError, match="exists and is public"):
        push(dataset, "user/public", private=True)
    assert hub.repos["user/public"].commits == before


def test_a_push_of_large_files_that_broke_off_goes_on_where_it_was(lfs: Hub, dataset: Path) -> None:
    lfs.break_off["^PUT /lfs"] = 1
    with pytest.raises(ConnectionError, match="push again, it goes on where it was"):
        push(dataset, REPO)
    sent = set(lfs.objects)
    assert sent
    assert "v3.0" not in lfs.repos[REPO].refs
    lfs.break_off.clear()
    lfs.requests.clear()
    push(dataset, REPO)
    assert lfs.count("^PUT /lfs") == len(set(lfs.objects) - sent)
    assert not any(lfs.count(f"^PUT /lfs/{oid}") for oid in sent)
    assert lfs.repos[REPO].files[VIDEO] == (dataset / VIDEO).read_bytes()


@pytest.mark.parametrize("where", ["preupload", "commit", "tag", "repos/create", "tree"])
def test_a_push_that_breaks_off_anywhere_can_be_made_again(hub: Hub, dataset: Path, where: str) -> None:
    hub.break_off[where] = 0
    with pytest.raises(ConnectionError, match="no connection to"):
        push(dataset, REPO)
    hub.break_off.clear()
    push(dataset, REPO)
    assert hub.repos[REPO].refs["v3.0"] == hub.repos[REPO].refs["main"]
    assert contents(dataset).items() <= hub.repos[REPO].files.items()


@pytest.mark.parametrize("large", [False, True])
def test_a_pull_that_breaks_off_leaves_nothing_and_goes_on(
    request: pytest.FixtureRequest, hub: Hub, dataset: Path, tmp_path: Path, large: bool
) -> None:
    if large:
        request.getfixturevalue("lfs")
    push(dataset, REPO)
    hub.break_off["^GET .*/resolve/"] = 3
    with pytest.raises(ConnectionError, match="pull again, it goes on where it was"):
        pull(REPO, tmp_path / "back")
    assert not (tmp_path / "back").exists()
    there = {path.name for path in (tmp_path / ".back.partial").rglob("*") if path.is_file()}
    assert there
    hub.break_off.clear()
    hub.requests.clear()
    pull(REPO, tmp_path / "back")
    assert hub.count("^GET .*/resolve/") < len(hub.repos[REPO].files) - 1
    assert contents(dataset).items() <= contents(tmp_path / "back").items()
    assert not (tmp_path / ".back.partial").exists()


@pytest.mark.parametrize("spoil", [lambda c: c[:-1] + b"?", lambda c: c[:-1], lambda c: c + b"more"])
def test_a_file_that_is_not_what_was_announced_is_refused(hub: Hub, dataset: Path, tmp_path: Path, spoil: Any) -> None:
    push(dataset, REPO)
    hub.spoil = lambda path, content: spoil(content) if path == VIDEO else content
    with pytest.raises((ConfigError, ConnectionError), match="pull again"):
        pull(REPO, tmp_path / "back")
    assert not (tmp_path / "back").exists()
    hub.spoil = lambda _, content: content
    pull(REPO, tmp_path / "back")


@pytest.mark.parametrize(
    "name", ["data/../../evil", "meta/../evil", "videos/..", "data/..\\evil", "data/a\0b", "meta/./../../evil"]
)
def test_no_file_is_written_outside(hub: Hub, dataset: Path, tmp_path: Path, name: str) -> None:
    push(dataset, REPO)
    hub.extra = [{"rfilename": name, "size": 1, "blobId": "0" * 40}]
    with pytest.raises(ConfigError, match="dangerous name"):
        pull(REPO, tmp_path / "folder")
    assert [path.name for path in tmp_path.iterdir()] == ["my_dataset"]


def test_what_is_no_part_of_a_dataset_is_not_fetched(hub: Hub, dataset: Path, tmp_path: Path) -> None:
    push(dataset, REPO)
    for name in ("/etc/passwd", "run.py", "data\\..\\evil", "../evil", ""):
        hub.repos[REPO].files[name] = b"evil"
    folder = pull(REPO, tmp_path / "back")
    assert set(contents(folder)) == {*contents(dataset), "README.md", "preview.jpg"}
    assert not hub.count("passwd|run.py|evil")


@pytest.mark.usefixtures("hub")
def test_links_that_lie_in_wait_are_refused(dataset: Path, tmp_path: Path) -> None:
    push(dataset, REPO)
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / ".back.partial").mkdir()
    (tmp_path / ".back.partial/meta").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(ConfigError, match="a symbolic link"):
        pull(REPO, tmp_path / "back")
    assert not any((tmp_path / "elsewhere").iterdir())


def test_a_dataset_larger_than_the_disk_is_refused_before_the_first_byte(
    hub: Hub, dataset: Path, tmp_path: Path
) -> None:
    push(dataset, REPO)
    hub.requests.clear()
    hub.extra = [{"rfilename": "data/bomb", "size": 10**17, "blobId": "0" * 40}]
    with pytest.raises(ConfigError, match=r"needs 100000000\.0 GB"):
        pull(REPO, tmp_path / "back")
    assert not hub.count("resolve")


@pytest.mark.usefixtures("hub")
def test_a_folder_that_is_in_use_is_not_touched(dataset: Path, tmp_path: Path) -> None:
    push(dataset, REPO)
    before = contents(dataset)
    with pytest.raises(ConfigError, match="exists already"):
        pull(REPO, dataset)
    assert contents(dataset) == before
    with pytest.raises(ConfigError, match="no such folder"):
        pull(REPO, tmp_path / "missing" / "back")
    (tmp_path / "empty").mkdir()
    assert pull(REPO, tmp_path / "empty") == tmp_path / "empty"


def test_revisions_are_the_tag_or_what_was_asked_for(hub: Hub, dataset: Path, tmp_path: Path) -> None:
    push(dataset, REPO)
    hub.repos[REPO].commit({**hub.repos[REPO].files, "meta/stats.json": b"half a push"})
    assert (pull(REPO, tmp_path / "tagged") / "meta/stats.json").read_bytes() == b"{}"
    assert (pull(REPO, tmp_path / "main", revision="main") / "meta/stats.json").read_bytes() == b"half a push"
    with pytest.raises(ConfigError, match="has no such revision"):
        pull(REPO, tmp_path / "other", revision="v9")
    del hub.repos[REPO].refs["v3.0"]
    assert (pull(REPO, tmp_path / "untagged") / "meta/stats.json").read_bytes() == b"half a push"


def test_what_is_no_dataset_is_not_left_under_its_name(hub: Hub, dataset: Path, tmp_path: Path) -> None:
    push(dataset, REPO)
    files = hub.repos[REPO].files
    hub.repos[REPO].commit({"README.md": b"a model"})
    with pytest.raises(ConfigError, match=r"has no meta/info\.json"):
        pull(REPO, tmp_path / "back", revision="main")
    hub.repos[REPO].commit({path: content for path, content in files.items() if path != VIDEO})
    with pytest.raises(ConfigError, match=r"file-000\.mp4: missing; episode 0 is in it"):
        pull(REPO, tmp_path / "back", revision="main")
    assert not (tmp_path / "back").exists()


def test_without_a_token_nothing_is_sent(hub: Hub, dataset: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("HF_TOKEN")
    with pytest.raises(ConfigError, match="no token of the Hub: run `hf auth login`, or set HF_TOKEN"):
        push(dataset, REPO)
    assert not hub.requests


def test_public_datasets_need_no_token_and_private_ones_do(
    hub: Hub, dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    push(dataset, REPO)
    monkeypatch.delenv("HF_TOKEN")
    pull(REPO, tmp_path / "back")
    hub.repos[REPO].private = True
    with pytest.raises(ConfigError, match="hf auth login"):
        pull(REPO, tmp_path / "again")


@pytest.mark.parametrize("repo_id", ["", "office", "a/b/c", "user/", "user/a b", "https://x/y", "../x", "user/..\n"])
def test_a_wrong_repository_id_is_one_line(hub: Hub, dataset: Path, tmp_path: Path, repo_id: str) -> None:
    with pytest.raises(ConfigError, match="is no repository id: it must be user/name"):
        push(dataset, repo_id)
    with pytest.raises(ConfigError, match="is no repository id: it must be user/name"):
        pull(repo_id, tmp_path / "back")
    assert not hub.repos


@pytest.mark.parametrize(
    ("status", "kind", "message"),
    [
        (401, ConfigError, "the token is missing, wrong or expired"),
        (403, ConfigError, "the token does not allow it"),
        (404, ConfigError, "there is no such dataset, or it is private"),
        (409, ConfigError, "the server refuses it (409)"),
        (500, ConnectionError, "the server answers 500"),
        (503, ConnectionError, "the server answers 503"),
    ],
)
def test_what_the_server_answers_is_one_line(
    hub: Hub, dataset: Path, tmp_path: Path, status: int, kind: type[Exception], message: str
) -> None:
    push(dataset, REPO)
    hub.status["preupload|revision"] = status
    for act in (lambda: push(dataset, REPO), lambda: pull(REPO, tmp_path / "back")):
        with pytest.raises(kind) as caught:
            act()
        assert message in str(caught.value)
        assert "\n" not in str(caught.value)
        assert TOKEN not in repr(caught.value)


def test_no_network_is_one_line(dataset: Path, tmp_path: Path, hub: Hub, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HF_ENDPOINT", "http://127.0.0.1:1")
    for act in (lambda: push(dataset, REPO), lambda: pull(REPO, tmp_path / "back")):
        with pytest.raises(ConnectionError, match=r"no connection to http://127\.0\.0\.1:1"):
            act()
    assert not hub.requests


def test_the_token_is_in_no_log_no_file_and_no_error(
    hub: Hub, dataset: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.DEBUG):
        push(dataset, REPO)
        hub.status["commit"] = 403
        (dataset / "meta/stats.json").write_text("{ }")
        with pytest.raises(ConfigError) as caught:
            push(dataset, REPO)
    assert TOKEN not in caplog.text
    assert TOKEN not in repr(caught.value) + str(caught.value)
    assert all(TOKEN.encode() not in content for content in hub.repos[REPO].files.values())
    done = run("data", "push", "my_dataset", "--repo-id", REPO, cwd=tmp_path, HF_HUB_VERBOSITY="debug", HF_DEBUG="")
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith("error: pushing")
    assert TOKEN not in done.stdout + done.stderr
    assert all(TOKEN.encode() not in content for content in contents(tmp_path).values())
