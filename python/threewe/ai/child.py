"""Policies in LeRobot's own environment: a child process of another Python, arrays over a pipe as plain bytes."""

from __future__ import annotations

import json
import math
import os
import select
import subprocess
import tempfile
import threading
import time
import weakref
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from threewe._arguments import as_file
from threewe.ai.checkpoint import read_checkpoint
from threewe.ai.folder import EMBEDDED, PREFIX, Policy, image_input, refuse_code
from threewe.ai.naming import Naming, policy_of
from threewe.errors import ConfigError, HardwareError

PROGRAM = Path(__file__).with_name("lerobot_child.py")
LOADING = 300.0
"""[s] until a checkpoint is loaded"""
PATIENCE = 60.0
"""[s] for one inference; a run gives up far earlier"""
LONGEST_LINE = 2**16
LARGEST = 2**24
"""[bytes] of actions"""
OFFLINE = {"HF_HUB_OFFLINE": "1", "TRANSFORMERS_OFFLINE": "1"}
"""A checkpoint that was vetted fetches nothing that was not."""


def start_child(
    folder: str | os.PathLike[str], python: str | os.PathLike[str], naming: Naming
) -> tuple[Policy, ChildEngine]:
    """Vets a checkpoint, then loads it in a process of `python`. Raises ConfigError."""
    checkpoint = read_checkpoint(folder)
    program = as_file("python", python).absolute()  # but no link is followed: it is what makes an environment
    if not program.is_file():
        raise ConfigError(f"python: {program}: no such file; it is the interpreter of LeRobot's environment")
    for text in _texts([checkpoint.config, *(step.config for step in (*checkpoint.before, *checkpoint.after))]):
        if Path(text).is_absolute() and Path(text).is_dir():  # of a backbone, such as `vlm_model_name`
            refuse_code(Path(text))
    language = EMBEDDED in checkpoint.inputs or checkpoint.reads_text
    policy = policy_of(checkpoint, naming, 2, "replace", language)
    cameras = zip(checkpoint.cameras(), policy.cameras, strict=True)
    names = {image_input(camera.name): name for name, camera in cameras}
    engine = ChildEngine(program, checkpoint.folder, names, set(checkpoint.inputs))
    black = {name: np.zeros((1, *f.shape), np.float32) for name, f in checkpoint.inputs.items()}
    given = {ours: black.pop(theirs) for ours, theirs in names.items()} | black
    shape = engine.infer(given, "").shape  # how many actions a chunk has, only it knows
    if len(shape) != 3 or shape[0] != 1 or not 2 <= shape[1] <= 1000 or shape[2] != len(policy.action):
        engine.close()
        raise ConfigError(f"{checkpoint.folder}: gives actions {shape}; expected (1, chunk, {len(policy.action)})")
    return replace(policy, chunk=shape[1], prefix=shape[1] - 1 if engine.takes_prefix else 0), engine


class ChildEngine:
    """Runs a checkpoint in a process of another Python."""

    def __init__(self, python: Path, folder: Path, names: dict[str, str], inputs: set[str]) -> None:
        """Starts it, and waits until the checkpoint is loaded. Raises ConfigError."""
        self._names, self._python = names, python
        self._one_at_a_time = threading.Lock()
        self._said = tempfile.TemporaryFile()  # noqa: SIM115 (as long as the process) what it and its libraries print
        words = [str(python), "-c", PROGRAM.read_text(encoding="utf-8"), str(folder.resolve())]
        try:
            self._process = subprocess.Popen(
                words,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._said,
                cwd="/",
                env={**os.environ, **OFFLINE},
            )
        except OSError as error:
            self._said.close()
            raise ConfigError(f"python: {python}: cannot be run: {error.strerror}") from None
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._to, self._from = self._process.stdin.fileno(), self._process.stdout.fileno()
        os.set_blocking(self._to, False)
        self.close = weakref.finalize(self, _end, self._process, self._said)
        try:
            answer = self._answer(b"", time.monotonic() + LOADING)[0]
        except HardwareError as error:
            raise ConfigError(f"{folder}: {error}") from None
        if "missing" in answer:
            self.close()
            raise ConfigError(f"python: {python}: has no LeRobot ({answer['missing']}): install it there")
        if answer.get("ready") is not True:
            self.close()
            raise ConfigError(f"{folder}: LeRobot does not load it: {answer.get('error', answer)}")
        self.takes_prefix = answer.get("rtc") is True
        """its `config.json` has real-time chunking switched on"""
        self._inputs = inputs | ({PREFIX} if self.takes_prefix else set())

    def infer(self, feed: dict[str, NDArray[np.float32]], instruction: str) -> NDArray[np.float32]:
        """See `Engine`. Raises HardwareError when the process has ended, hangs, or sends what it should not."""
        given = {self._names.get(name, name): values for name, values in feed.items()}
        arrays = {n: np.ascontiguousarray(v, "<f4") for n, v in given.items() if n in self._inputs}
        head = {"arrays": {n: ["<f4", list(v.shape)] for n, v in arrays.items()}, "task": instruction}
        data = b"".join([json.dumps(head).encode(), b"\n", *(v.tobytes() for v in arrays.values())])
        with self._one_at_a_time:
            answer, content = self._answer(data, time.monotonic() + PATIENCE)
        if "error" in answer:
            raise HardwareError(f"LeRobot: {str(answer['error'])[:500]}")
        actions: NDArray[np.float32] = np.frombuffer(content, "<f4").reshape(_shape(answer))
        return actions

    def _answer(self, data: bytes, deadline: float) -> tuple[dict[str, Any], bytes]:
        """Sends a message and waits for one. A process that did not answer rightly is ended."""
        try:
            received = self._exchange(data, b"", deadline, lambda got: b"\n" in got or len(got) > LONGEST_LINE)
            line, _, rest = received.partition(b"\n")
            answer = json.loads(line)
            if not isinstance(answer, dict):
                raise ValueError("no object")
            wanted = 4 * math.prod(_shape(answer)) if "arrays" in answer else 0
            content = self._exchange(b"", rest, deadline, lambda got: len(got) >= wanted)
            if len(content) != wanted:
                raise ValueError(f"{len(content)} bytes instead of {wanted}")
            return answer, content
        except (ValueError, TypeError, KeyError, RecursionError) as error:
            self.close()
            raise HardwareError(f"the process of {self._python} sent what is no answer: {error}") from None
        except TimeoutError:
            self.close()
            raise HardwareError(f"the process of {self._python} hangs, and was ended") from None
        except (BrokenPipeError, EOFError):
            raise HardwareError(f"the process of {self._python} ended ({self._ended()})") from None

    def _exchange(self, data: bytes, received: bytes, deadline: float, is_enough: Any) -> bytes:
        left, parts = memoryview(data), bytearray(received)
        while len(left) > 0 or not is_enough(parts):
            if self._process.returncode is not None or not self.close.alive:
                raise EOFError
            remaining = deadline - time.monotonic()
            readable, writable, _ = select.select(
                [self._from], [self._to] if len(left) > 0 else [], [], max(0.0, remaining)
            )
            if not readable and not writable:
                raise TimeoutError
            if writable:
                left = left[os.write(self._to, left) :]
            if readable:
                part = os.read(self._from, 2**20)
                if not part:
                    raise EOFError
                parts += part
        return bytes(parts)

    def _ended(self) -> str:
        """How, and its last words."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(5.0)  # on a busy computer it takes its time to end
        words = self._last_words()
        self.close()
        status = self._process.returncode
        return (f"signal {-status}" if status is not None and status < 0 else f"status {status}") + words

    def _last_words(self) -> str:
        if self._said.closed:
            return ""
        self._said.seek(0, os.SEEK_END)
        self._said.seek(max(0, self._said.tell() - 2000))
        lines = self._said.read().decode("utf-8", "replace").strip().splitlines()
        return f": {lines[-1][:200]}" if lines else ""


def _texts(content: Any) -> Iterator[str]:
    """All texts of a JSON value that may be paths."""
    if isinstance(content, str) and len(content) < 4096 and "\0" not in content:
        yield content
    elif isinstance(content, Mapping):
        for each in content.values():
            yield from _texts(each)
    elif isinstance(content, list):
        for each in content:
            yield from _texts(each)


def _shape(answer: dict[str, Any]) -> tuple[int, ...]:
    """Of the actions in an answer. Raises ValueError."""
    kind, shape = answer["arrays"]["action"]
    whole = isinstance(shape, list) and len(shape) <= 4 and all(type(n) is int and 0 < n < 2**20 for n in shape)
    if kind != "<f4" or not whole or 4 * math.prod(shape) > LARGEST:
        raise ValueError(f"actions of {kind} {shape}")
    return tuple(shape)


def _end(process: subprocess.Popen[bytes], said: IO[bytes]) -> None:
    process.kill()
    said.close()
    for stream in (process.stdin, process.stdout):
        if stream is not None:
            with suppress(OSError):
                stream.close()
    process.wait()
