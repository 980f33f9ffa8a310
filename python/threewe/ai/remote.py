"""Policies on another machine, by openpi's websocket protocol: `threewe policy serve`, or openpi's own server."""

from __future__ import annotations

import threading
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe._core import Kinematics
from threewe._extras import needed_for
from threewe.ai.folder import CAMERA, PREFIX, STATE, CameraInput, Fields, Policy, Quantity, image_input, parse_policy
from threewe.ai.naming import LATENCY, NUMBERS, OURS, Naming
from threewe.ai.wire import LARGEST, pack, unpack
from threewe.errors import ConfigError, ConnectionError

CONNECTING = 5.0
"""[s] until a server has described itself"""
FIRST = 120.0
"""[s] for the first inference, before which some servers compile"""
PATIENCE = 0.75
"""[s] for each other one; a run gives up after 1 s"""
PROMPT, ACTIONS = "prompt", "actions"
SIDE = 224
"""[px] of the pictures that openpi's models take"""


def connect_policy(address: str, naming: Naming) -> tuple[Policy, RemoteEngine]:
    """Connects to a server and learns what it needs. Raises ConfigError, ConnectionError."""
    engine = RemoteEngine(address)
    about = engine.about
    if about.get("format") == "3we-policy":
        if naming.rename or naming.rate is not None:
            raise ConfigError(f"{address}: describes itself: leave out rename= and rate=, which other servers need")
        return parse_policy(Fields(address, "", about), Path(address)), engine
    policy, engine.keys = _foreign(address, naming)
    given = {name: np.zeros(shape, np.float32) for name, shape in policy.inputs().items()}
    engine.patience = FIRST
    shape = engine.infer(given, "do nothing").shape
    engine.patience = PATIENCE
    if len(shape) != 3 or not 2 <= shape[1] <= 1000 or shape[2] != len(policy.action):
        raise ConfigError(
            f"{address}: gives actions {shape[1:]}; rename= names {len(policy.action)} numbers "
            f"({', '.join(q.name for q in policy.action)})"
        )
    return replace(policy, chunk=shape[1]), engine


def _foreign(address: str, naming: Naming) -> tuple[Policy, dict[str, str]]:
    """A server that says nothing of itself: `rename` names all that it takes and gives."""
    keys: dict[str, str] = {}
    numbers: dict[str, tuple[Quantity, ...]] = {}
    cameras = []
    for theirs, ours in naming.rename.items():
        if isinstance(ours, str):
            cameras.append(CameraInput(ours, SIDE, SIDE, "rgb"))
            keys[image_input(ours)] = theirs
        else:
            if unknown := [name for name in ours if name not in NUMBERS]:
                raise ConfigError(f"{address}: rename: {theirs!r} has {unknown[0]!r}; a robot of 3we has {OURS}")
            numbers[theirs] = tuple(Quantity(*NUMBERS[name], 0.0, 1.0) for name in ours)
            if theirs != ACTIONS:
                keys[STATE] = theirs
    if not cameras or ACTIONS not in numbers or len(numbers) > 2 or naming.rate is None:
        raise ConfigError(
            f"{address}: the server does not say what it takes and gives; a robot of 3we has {CAMERA}, {OURS}: "
            "name all of it, such as rename={'observation/image': 'camera', 'observation/state': ['vx', 'vy', "
            "'omega'], 'actions': ['vx', 'vy', 'omega']}, rate=10"
        )
    action = numbers.pop(ACTIONS)
    state = next(iter(numbers.values()), ())
    kinematics = Kinematics.holonomic if any(q.name == "vy" for q in action) else Kinematics.differential
    policy = Policy(
        Path(address), kinematics, tuple(cameras), state, action, naming.rate, 2, LATENCY, "replace", True, {}
    )
    return policy, keys


class RemoteEngine:
    """Asks a server for each chunk; after a fault it connects again."""

    def __init__(self, address: str) -> None:
        """Connects. Raises ConfigError, ConnectionError."""
        with needed_for("policies over the network", "policy"):
            import msgpack  # noqa: F401
            import websockets.sync.client  # noqa: F401
        self.address, self.patience = address, PATIENCE
        self._one_at_a_time = threading.Lock()
        self.keys: dict[str, str] = {}
        """what the server calls an input, where it is another name"""
        self._connection: Any = None
        self._open = ExitStack()
        self._described = self._connect()
        self.about: dict[str, Any] = unpack(self._described)
        """the server's description of itself"""

    def infer(self, feed: dict[str, NDArray[np.float32]], instruction: str) -> NDArray[np.float32]:
        """See `Engine`. Raises ConnectionError when the server has gone, is late, or sends what it should not."""
        message: dict[str, Any] = {PROMPT: instruction} if instruction else {}
        for name, values in feed.items():
            if name in (STATE, PREFIX):
                message[self.keys.get(name, name)] = values[0]
            elif values.ndim == 4:
                pixels = np.rint(values[0].transpose(1, 2, 0) * 255).astype(np.uint8)
                message[self.keys.get(name, name)] = np.ascontiguousarray(pixels)
        with self._one_at_a_time:
            answer = self._ask(pack(message))
        actions = answer.get(ACTIONS) if isinstance(answer, dict) else None
        if not isinstance(actions, np.ndarray) or actions.ndim != 2 or actions.dtype.kind != "f":
            raise ConnectionError(f"{self.address}: answered without 'actions' (chunk, numbers)")
        return actions[None].astype(np.float32)

    def _ask(self, message: bytes) -> Any:
        from websockets.exceptions import WebSocketException

        if self._connection is None and self._connect() != self._described:
            self._close()
            raise ConnectionError(f"{self.address}: serves another policy than before: load it anew")
        try:
            self._connection.send(message)
            answer = self._connection.recv(timeout=self.patience)
            if isinstance(answer, str):
                raise ConnectionError(f"{self.address}: the server says: {answer.strip().splitlines()[-1][:300]}")
            return unpack(answer)
        except TimeoutError:
            self._close()  # an answer that is late must not be taken for the next one
            raise ConnectionError(f"{self.address}: no answer within {self.patience:g} s") from None
        except ValueError as error:
            self._close()
            raise ConnectionError(f"{self.address}: {error}") from None
        except (WebSocketException, OSError) as error:
            self._close()
            if isinstance(error, ConnectionError):
                raise
            raise ConnectionError(f"{self.address}: the connection broke off: {error}") from None

    def _connect(self) -> bytes:
        """The server's description of itself, as it sent it."""
        from websockets.exceptions import InvalidURI, WebSocketException
        from websockets.sync.client import connect

        try:
            opened = connect(
                self.address,
                proxy=None,
                compression=None,
                max_size=LARGEST,
                open_timeout=CONNECTING,
                close_timeout=0.2,
            )
            self._connection = self._open.enter_context(opened)
            described: bytes = self._connection.recv(timeout=CONNECTING)
            about = unpack(described)
        except InvalidURI:
            raise ConfigError(f"{self.address}: no address; expected ws://host:port") from None
        except (WebSocketException, OSError, ValueError) as error:
            self._close()
            what = "no description within 5 s" if isinstance(error, TimeoutError) else error
            raise ConnectionError(
                f"{self.address}: no policy server: {what}; start one: threewe policy serve"
            ) from None
        if not isinstance(about, dict):
            self._close()
            raise ConnectionError(f"{self.address}: no policy server: it describes itself as {str(about)[:60]!r}")
        return described

    def _close(self) -> None:
        self._connection = None
        with suppress(Exception):
            self._open.close()
