"""Policy server by openpi's websocket protocol, so that one machine thinks for another."""

from __future__ import annotations

import threading
import time
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe._extras import needed_for
from threewe.ai.folder import EMBEDDED, PREFIX, STATE, Policy, image_input, policy_fields
from threewe.ai.remote import ACTIONS, PROMPT
from threewe.ai.runner import VLARunner, network_input
from threewe.ai.wire import LARGEST, pack, unpack
from threewe.errors import ConfigError, ContractError, ThreeweError

LOOPBACK = "127.0.0.1"


class PolicyServer:
    """Serves a policy to any number of clients: `with PolicyServer(runner) as server:` gives `server.address`.

    Pages of browsers are refused, whatever they say. It neither knows who asks nor encrypts: on other addresses than
    loopback, every program that reaches it may use it.
    """

    def __init__(self, runner: VLARunner, host: str = LOOPBACK, port: int = 0) -> None:
        """Listens; port 0 is a free one. Raises ConfigError when it cannot."""
        with needed_for("serving a policy", "policy"):
            import msgpack  # noqa: F401
            from websockets.sync.server import serve
        self._runner, self._one_at_a_time = runner, threading.Lock()
        try:
            self._server = serve(self._talk, host, port, compression=None, max_size=LARGEST, origins=[None])
        except OSError as error:
            raise ConfigError(f"{host}:{port}: cannot listen there: {error.strerror or error}") from None
        name, port = self._server.socket.getsockname()[:2]
        self.address = f"ws://{f'[{name}]' if ':' in name else name}:{port}"
        """Where it is."""

    def __enter__(self) -> PolicyServer:
        threading.Thread(target=self.serve_forever, name="policy server", daemon=True).start()
        return self

    def __exit__(self, *error: object) -> None:
        self._server.shutdown()

    def serve_forever(self) -> None:
        """Answers until the program is interrupted; then it lets go of its clients, who would keep it from ending."""
        try:
            self._server.serve_forever()
        finally:
            self._server.shutdown()

    def _talk(self, connection: Any) -> None:
        from websockets.exceptions import ConnectionClosed

        with suppress(ConnectionClosed):
            connection.send(pack(description(self._runner.policy)))
            while True:
                connection.send(self._answer(connection.recv()))

    def _answer(self, message: str | bytes) -> bytes | str:
        try:
            if isinstance(message, str):
                raise ContractError("a text; expected an observation in msgpack")
            observation = unpack(message)
            begun = time.perf_counter()
            with self._one_at_a_time:
                actions = self._actions(observation)
            timing = {"infer_ms": 1e3 * (time.perf_counter() - begun)}
            return pack({ACTIONS: actions, "server_timing": timing})
        except (ThreeweError, ValueError) as error:  # openpi's servers answer in text, too
            return f"{type(error).__name__}: {error}"

    def _actions(self, observation: Any) -> NDArray[np.float32]:
        """(chunk, numbers) in the policy's units."""
        policy = self._runner.policy
        if not isinstance(observation, dict):
            raise ContractError(f"an observation is a map, got {type(observation).__name__}")
        wanted: dict[Any, tuple[int, ...]] = {image_input(c.name): (c.height, c.width, 3) for c in policy.cameras}
        wanted |= {STATE: (len(policy.state),)} if policy.state else {}
        wanted |= {PREFIX: policy.inputs()[PREFIX][1:]} if policy.prefix else {}
        shapes = {name: each.shape for name, each in observation.items() if isinstance(each, np.ndarray)}
        if shapes != wanted:
            raise ContractError(f"the policy takes {_listed(wanted)}; got {_listed(shapes)}")
        instruction = observation.get(PROMPT, "")
        if not isinstance(instruction, str):
            raise ContractError(f"{PROMPT} must be a text, got {type(instruction).__name__}")
        feed = {}
        for camera in policy.cameras:
            pixels = observation[image_input(camera.name)]
            if pixels.dtype != np.uint8:
                raise ContractError(f"{image_input(camera.name)} must be uint8, got {pixels.dtype}")
            feed[image_input(camera.name)] = network_input(pixels[:, :, ::-1], camera)  # which takes BGR
        if policy.state:
            mean, std = (np.array([getattr(q, name) for q in policy.state]) for name in ("mean", "std"))
            feed[STATE] = ((observation[STATE] - mean) / std).astype(np.float32)[None]
        mean, std = (np.array([getattr(q, name) for q in policy.action], np.float32) for name in ("mean", "std"))
        if policy.prefix:
            numbers, given = observation[PREFIX][:, :-1], observation[PREFIX][:, -1:]
            feed[PREFIX] = np.concatenate([given * (numbers - mean) / std, given], 1).astype(np.float32)[None]
        embedding = self._runner._embedding(instruction)
        if embedding is not None:
            feed[EMBEDDED] = embedding
        output = self._runner._engine.infer(feed, instruction)[0]
        return np.asarray(output * std + mean, np.float32)


def description(policy: Policy) -> dict[str, Any]:
    """What a server sends first: `policy.json`, for pictures in RGB and numbers in their units."""
    plain = replace(
        policy,
        cameras=tuple(replace(camera, color="rgb") for camera in policy.cameras),
        state=tuple(replace(quantity, mean=0.0, std=1.0) for quantity in policy.state),
        action=tuple(replace(quantity, mean=0.0, std=1.0) for quantity in policy.action),
    )
    return policy_fields(plain)


def _listed(shapes: dict[Any, tuple[int, ...]]) -> str:
    return ", ".join(f"{name} {'x'.join(map(str, shape))}" for name, shape in shapes.items()) or "nothing"
