"""A held-out split is published as hashes; who reveals its secret cannot have chosen it since."""

from __future__ import annotations

import json
import stat
import subprocess
from pathlib import Path

import command_line
import pytest
from threewe import ConfigError
from threewe.benchmark import commitments
from threewe.benchmark.commitments import (
    commit,
    draw_sets,
    hash_of,
    load_commitment,
    new_secret,
    read_secret,
    reveal,
    to_text,
)
from threewe.benchmark.sampling import HELD_OUT

ROOT = Path(__file__).resolve().parents[3]
OTHER = "0123456789abcdef" * 4


def command(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return command_line.threewe("benchmark", "episodes", *arguments, cwd=folder)


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Splits of one building, without the exploration that takes a minute."""
    monkeypatch.setattr("threewe.benchmark.sampling.BUILDINGS", 1)
    monkeypatch.setattr(commitments, "HELD_OUT", ("pointnav", "objectnav"))


def test_the_published_commitment_is_one() -> None:
    published = load_commitment()
    assert published.name == "generated_v1"
    assert sorted(published.sets) == sorted(f"{task}_generated_v1" for task in HELD_OUT)
    assert len({published.secret, *published.sets.values()}) == 1 + len(HELD_OUT)
    text = (ROOT / "assets/commitments/generated_v1.json").read_text()
    assert text == to_text(published)
    with pytest.raises(ConfigError, match="generated_v1: another secret"):
        reveal(OTHER, published)
    assert not list((ROOT / "assets/episodes").glob("*_generated_*")), "the sets themselves are held out"


def test_a_secret_that_is_committed_to_is_revealed(small: None, tmp_path: Path) -> None:
    del small
    hashed = new_secret(tmp_path / "secret")
    secret = read_secret(tmp_path / "secret")
    assert hashed == hash_of(secret)
    assert len(secret) == 64
    assert stat.S_IMODE((tmp_path / "secret").stat().st_mode) == 0o600
    texts = draw_sets(secret)
    commitment = commit(secret, texts)
    (tmp_path / "published.json").write_text(to_text(commitment))
    assert load_commitment(tmp_path / "published.json") == commitment
    assert secret not in to_text(commitment) + "".join(texts.values())
    assert all(json.loads(text)["commitment"] == hashed for text in texts.values())
    reveal(secret, commitment)
    assert commit(secret, draw_sets(secret)) == commitment, "anyone draws the same sets again"
    for wrong in (secret[:-1], secret + "0", secret.upper(), OTHER):
        with pytest.raises(ConfigError, match="another secret"):
            reveal(wrong, commitment)
    assert commit(OTHER, draw_sets(OTHER)).sets != commitment.sets


def test_no_secret_is_drawn_over_another_and_none_can_be_guessed(tmp_path: Path) -> None:
    new_secret(tmp_path / "secret")
    with pytest.raises(ConfigError, match="a secret that is lost cannot be drawn again"):
        new_secret(tmp_path / "secret")
    (tmp_path / "short").write_text("hunter2\n")
    with pytest.raises(ConfigError, match="7 characters can be guessed: expected 32 or more") as refused:
        read_secret(tmp_path / "short")
    assert "hunter2" not in str(refused.value)
    assert new_secret(tmp_path / "one") != new_secret(tmp_path / "two")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("{", "Expecting"),
        ("[]", "expected name, secret, sets"),
        ('{"name": "x", "secret": "y"}', "expected name, secret, sets"),
        ('{"name": "x", "secret": "y", "sets": {}}', "secret: expected a SHA-256"),
        (json.dumps({"name": "x", "secret": "0" * 64, "sets": {"a": "0" * 63}}), r"sets\.a: expected a SHA-256"),
        (json.dumps({"name": 1, "secret": "0" * 64, "sets": {}}), "expected a name"),
        ("[" * 100_000, "bad.json"),
    ],
)
def test_a_bad_commitment_is_named(content: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "bad.json").write_text(content)
    with pytest.raises(ConfigError, match=message) as refused:
        load_commitment(tmp_path / "bad.json")
    assert str(refused.value).startswith(str(tmp_path / "bad.json"))


def test_the_commands_say_whether_it_is_the_one(tmp_path: Path) -> None:
    drawn = command(tmp_path, "secret", "kept")
    assert drawn.returncode == 0, drawn.stderr
    secret = (tmp_path / "kept").read_text().strip()
    assert drawn.stdout == f"kept: secret with SHA-256 {hash_of(secret)}\n"
    published = {"name": "generated_v1", "secret": hash_of(secret), "sets": {}}
    (tmp_path / "published.json").write_text(json.dumps(published))
    done = command(tmp_path, "reveal", "kept", "--commitment", "published.json")
    assert (done.returncode, done.stdout) == (0, "revealed: the secret is the one that generated_v1 commits to\n")
    done = command(tmp_path, "reveal", "kept")
    assert done.returncode == 1
    assert done.stdout.startswith("refused: generated_v1: another secret, with SHA-256")
    assert secret not in done.stdout + done.stderr
    done = command(tmp_path, "reveal", "kept", "--commitment", "generatde_v1")
    assert done.returncode == 2
    assert "did you mean 'generated_v1'" in done.stderr
