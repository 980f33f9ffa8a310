"""Bundles: a run as one file that anyone can replay. The same run gives the same bytes."""

from __future__ import annotations

import base64
import hashlib
import io
import json
import math
import re
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any, NoReturn

from threewe._files import require_file
from threewe.benchmark.runner import Result
from threewe.errors import ConfigError

LARGEST = 64 << 20  # [bytes] of a bundle, packed and unpacked: nothing in it is compressed
MOST_FILES = 100_000
LONGEST_SHOWN = 40  # characters of a text in a message
LONGEST_INTEGER = 20  # digits: what 64 bits hold
EARLIEST = (1980, 1, 1, 0, 0, 0)  # the date of all files
KINDS = {"commands": "f64", "actions": "f32", "grid": "i8", "talk": "jsonl"}
NAME = re.compile(r"(manifest|results)\.json|" + "|".join(rf"({kind}/\d{{5}}\.{end})" for kind, end in KINDS.items()))


class BundleError(ConfigError):
    """A bundle is refused; the message says why."""


@dataclass(frozen=True)
class Bundle:
    """What a bundle holds."""

    results: dict[str, Any]
    files: dict[str, bytes]  # by name: what can be replayed

    def part(self, kind: str, number: int) -> bytes | None:
        """What there is of a kind of an episode, by its number in the results; None where there is nothing."""
        return self.files.get(_name(kind, number))


def write_bundle(path: Path, results: Mapping[str, Any], outcomes: Sequence[Result]) -> None:
    """Writes a bundle. Raises ConfigError for one that would be too large."""
    files = {"results.json": text_of(results)}
    for number, outcome in enumerate(outcomes):
        for kind, text in outcome["replayed"].items():
            files[_name(kind, number)] = base64.b64decode(text)
    content = pack(files)
    if len(content) > LARGEST:
        raise ConfigError(f"{path}: {len(content)} bytes are more than the {LARGEST} of a bundle: run fewer episodes")
    path.write_bytes(content)


def pack(files: Mapping[str, bytes]) -> bytes:
    """The bytes of a bundle of these files, with their manifest."""
    hashes = {name: hashlib.sha256(content).hexdigest() for name, content in sorted(files.items())}
    return archived({**files, "manifest.json": text_of({"format": "threewe-bundle/1", "files": hashes})})


def archived(files: Mapping[str, bytes]) -> bytes:
    """The bytes of an archive of these files and nothing else."""
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w", zipfile.ZIP_STORED) as archive:
        for name, content in sorted(files.items()):
            info = zipfile.ZipInfo(name, EARLIEST)
            info.create_system, info.external_attr = 3, 0o644 << 16
            archive.writestr(info, content)
    return written.getvalue()


def read_bundle(path: Path) -> Bundle:
    """Reads a bundle. Raises BundleError for any other file, before anything of it is unpacked."""
    require_file(path)
    if path.stat().st_size > LARGEST:
        raise BundleError(f"{path}: larger than {LARGEST} bytes")
    content = path.read_bytes()
    files = _unpacked(path, content)
    manifest = parse_json(path, "manifest.json", files.pop("manifest.json", b""))
    hashes = manifest.get("files")
    if not isinstance(hashes, dict) or sorted(hashes) != sorted(files):
        raise BundleError(f"{path}: manifest.json does not name the files that are there")
    for name, value in files.items():
        if hashes[name] != hashlib.sha256(value).hexdigest():
            raise BundleError(f"{path}: {name} is not the file that manifest.json names: its hash differs")
    if pack(files) != content:
        raise BundleError(f"{path}: not canonical: names are sorted, dates zero, nothing else is in the archive")
    if "results.json" not in files:
        raise BundleError(f"{path}: results.json is missing")
    text = files.pop("results.json")
    results = parse_json(path, "results.json", text)
    if text_of(results) != text:
        raise BundleError(f"{path}: results.json: not canonical: keys are sorted and there once, one space a level")
    return Bundle(results, files)


def parse_json(path: Path, name: str, content: bytes) -> dict[str, Any]:
    """An object of JSON, in which all numbers are finite and all texts can be printed."""
    try:
        value = json.loads(content.decode(), parse_constant=_not_finite, parse_float=_finite, parse_int=_small)
        for text in _texts_of(value):
            if not text.isprintable():
                raise ValueError(f"{text[:LONGEST_SHOWN]!r} cannot be printed")
    except (ValueError, RecursionError) as error:
        raise BundleError(f"{path}: {name}: {error}") from None
    if not isinstance(value, dict):
        raise BundleError(f"{path}: {name}: expected an object")
    return value


def text_of(value: Mapping[str, Any]) -> bytes:
    """JSON, always in the same form."""
    return (json.dumps(value, sort_keys=True, indent=1, allow_nan=False) + "\n").encode()


def _unpacked(path: Path, content: bytes) -> dict[str, bytes]:
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            infos = archive.infolist()
            _require_plain(path, infos)
            return {info.filename: archive.read(info) for info in infos}
    except (zipfile.BadZipFile, EOFError, OSError, ValueError, NotImplementedError, RuntimeError) as error:
        if isinstance(error, BundleError):
            raise
        raise BundleError(f"{path}: no bundle: {error}") from None


def _require_plain(path: Path, infos: Sequence[zipfile.ZipInfo]) -> None:
    """By the table of contents alone."""
    if len(infos) > MOST_FILES:
        raise BundleError(f"{path}: {len(infos)} files are more than {MOST_FILES}")
    names = [info.filename for info in infos]
    if len(set(names)) != len(names):
        raise BundleError(f"{path}: a name is there twice")
    for info in infos:
        if not NAME.fullmatch(info.filename):
            raise BundleError(f"{path}: {info.filename!r} is no file of a bundle")
        if info.compress_type != zipfile.ZIP_STORED or info.file_size != info.compress_size:
            raise BundleError(f"{path}: {info.filename} is compressed, and nothing in a bundle is")
    if sum(info.file_size for info in infos) > LARGEST:
        raise BundleError(f"{path}: its files are larger than {LARGEST} bytes")


def _name(kind: str, number: int) -> str:
    return f"{kind}/{number:05}.{KINDS[kind]}"


def _texts_of(value: Any) -> Iterator[str]:
    """All keys and texts in it."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict | list):
        for part in chain(value, value.values()) if isinstance(value, dict) else value:
            yield from _texts_of(part)


def _not_finite(text: str) -> NoReturn:
    raise ValueError(f"{text[:LONGEST_SHOWN]} is no number of a result")


def _finite(text: str) -> float:
    return value if math.isfinite(value := float(text)) else _not_finite(text)


def _small(text: str) -> int:
    return int(text) if len(text) <= LONGEST_INTEGER else _not_finite(text)
