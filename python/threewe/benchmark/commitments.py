"""Commitments: a held-out split published as hashes, so that who reveals its secret later cannot have chosen it since.

A file in `assets/commitments` has the SHA-256 of the secret that the buildings of `generated` follow from, and of each
set of episodes as it was drawn then. Its keeper has the secret and the sets; when the split is retired the secret is
published, and anyone checks it against the file.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import secrets
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from threewe._core import asset_directories, unknown_name
from threewe._files import read_text
from threewe.benchmark.episodes import to_json
from threewe.benchmark.sampling import COLUMNS, HELD_OUT, VERSION, make_episodes
from threewe.errors import ConfigError

NAME = f"generated_v{VERSION}"
SHORTEST_SECRET = 32  # characters: one that can be guessed is none once its hash is public
HASH = re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True)
class Commitment:
    """What is published of a held-out split."""

    name: str  # such as generated_v1
    secret: str  # SHA-256 of the secret
    sets: dict[str, str]  # SHA-256 of each set's file, by the set's name


def new_secret(path: Path) -> str:
    """Writes a secret of 256 random bits that its owner alone can read, and returns its SHA-256.

    Raises ConfigError where a file is there already: without its secret a split that was committed to is lost.
    """
    try:
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except FileExistsError:
        raise ConfigError(f"{path}: exists, and a secret that is lost cannot be drawn again: choose another") from None
    secret = secrets.token_hex(32)
    with os.fdopen(descriptor, "w") as file:
        file.write(secret + "\n")
    return hash_of(secret)


def read_secret(path: Path) -> str:
    """The secret of the split `generated`, from the file that its keeper has."""
    secret = read_text(path).strip()
    if len(secret) < SHORTEST_SECRET:
        raise ConfigError(
            f"{path}: {len(secret)} characters can be guessed: expected {SHORTEST_SECRET} or more, as "
            "`threewe benchmark episodes secret` draws them"
        )
    return secret


def hash_of(secret: str) -> str:
    """SHA-256 of a secret."""
    return hashlib.sha256(secret.encode()).hexdigest()


def draw_sets(secret: str, on_done: Callable[[str], object] = lambda _: None) -> dict[str, str]:
    """The text of each set's file, by the set's name. Takes minutes."""
    texts = {}
    for task in HELD_OUT:
        made = make_episodes(task, "generated", secret=secret)
        texts[made["name"]] = to_json(made, COLUMNS[task])
        on_done(made["name"])
    return texts


def commit(secret: str, texts: dict[str, str]) -> Commitment:
    """What is to be published of these sets."""
    return Commitment(NAME, hash_of(secret), {name: hash_of(text) for name, text in texts.items()})


def reveal(secret: str, commitment: Commitment) -> None:
    """Raises ConfigError unless that is the secret that was committed to."""
    if hash_of(secret) != commitment.secret:
        raise ConfigError(
            f"{commitment.name}: another secret, with SHA-256 {hash_of(secret)}: it commits to {commitment.secret}"
        )


def to_text(commitment: Commitment) -> str:
    """As a file holds it."""
    return json.dumps(asdict(commitment), indent=2) + "\n"


def load_commitment(name: str | Path = NAME) -> Commitment:
    """A commitment by name, or of a file. Raises ConfigError naming what is wrong."""
    path = _find(name)
    try:
        content: Any = json.loads(read_text(path))
    except (ValueError, RecursionError) as error:
        if isinstance(error, ConfigError):
            raise
        raise ConfigError(f"{path}: {error}") from None
    fields = list(Commitment.__annotations__)
    if not isinstance(content, dict) or sorted(content) != sorted(fields):
        raise ConfigError(f"{path}: expected {', '.join(fields)}")
    sets = content["sets"]
    if not isinstance(content["name"], str) or not isinstance(sets, dict):
        raise ConfigError(f"{path}: expected a name, and sets by their names")
    for place, value in {"secret": content["secret"], **{f"sets.{one}": sets[one] for one in sets}}.items():
        if not isinstance(value, str) or not HASH.fullmatch(value):
            raise ConfigError(f"{path}: {place}: expected a SHA-256 as 64 hexadecimal digits")
    return Commitment(content["name"], content["secret"], sets)


def _find(name: str | Path) -> Path:
    if Path(name).suffix == ".json":
        return Path(name)
    known = {file.stem: file for folder in asset_directories() for file in Path(folder).glob("commitments/*.json")}
    if str(name) not in known:
        raise ConfigError(unknown_name("commitment", str(name), sorted(known)))
    return known[str(name)]
