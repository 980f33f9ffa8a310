"""A policy on another machine: openpi's protocol from both sides, and what servers and clients do wrong."""

from __future__ import annotations

import asyncio
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
from ai import policies
from threewe import ConfigError, ConnectionError, Robot, Velocity
from threewe.ai import VLARunner, remote, wire
from threewe.ai.serving import PolicyServer
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.sync.server import serve

SIZE = (policies.HEIGHT, policies.WIDTH)
STATE = {"name": "vx", "unit": "m/s", "mean": 0.1, "std": 2.0}


@pytest.fixture
def runner(tmp_path: Path) -> VLARunner:
    model = policies.graph((0.1, 0.0, 0.0), red=0.5)
    action = [{**each, "mean": 0.05, "std": 0.5} for each in policies.DESCRIPTION["action"]]
    action[2]["unit"] = "deg/s"
    return VLARunner.from_pretrained(policies.write(tmp_path / "policy", model, action=action))


@contextmanager
def served(talk: Callable[[Any], None]) -> Iterator[str]:
    """A server that does what `talk` does."""
    with serve(talk, "127.0.0.1", 0, compression=None) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield f"ws://127.0.0.1:{server.socket.getsockname()[1]}"
        server.shutdown()


def test_another_machine_gives_the_same_actions(runner: VLARunner) -> None:
    random = np.random.default_rng(1)
    with PolicyServer(runner) as server:
        assert server.address.startswith("ws://127.0.0.1:")
        far = VLARunner.from_pretrained(server.address)
        assert far.policy.chunk == runner.policy.chunk
        for _ in range(5):
            picture = random.integers(0, 256, (*SIZE, 3), np.uint8)
            there = far.predict_chunk(picture, "go to the chair")
            assert there == pytest.approx(runner.predict_chunk(picture, "go to the chair"), abs=1e-6)


def test_the_command_serves_until_it_is_interrupted(runner: VLARunner) -> None:
    program = "from threewe.cli import main; main()"
    command = [sys.executable, "-u", "-c", program, "policy", "serve", str(runner.policy.folder), "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        address = server.stdout.readline().split()[-1]
        try:
            far = VLARunner.from_pretrained(address)
            picture = np.random.default_rng(1).integers(0, 256, (*SIZE, 3), np.uint8)
            there = far.predict_chunk(picture, "go to the chair")
            assert there == pytest.approx(runner.predict_chunk(picture, "go to the chair"), abs=1e-6)
        finally:
            server.send_signal(signal.SIGINT)
    with pytest.raises(ConnectionError):
        VLARunner.from_pretrained(address)


def test_it_drives_from_another_machine_as_from_here(runner: VLARunner) -> None:
    async def drive(runner: VLARunner) -> Any:
        async with Robot(image_size=SIZE) as robot:
            return await runner.run(robot, "go to the chair", timeout=1.0)

    with PolicyServer(runner) as server:
        assert asyncio.run(drive(VLARunner.from_pretrained(server.address))) == asyncio.run(drive(runner))


def test_red_is_red_on_the_other_side(tmp_path: Path) -> None:
    red = np.zeros((*SIZE, 3), np.uint8)
    red[:, :, 2] = 255  # BGR
    for color, ahead in (("rgb", 1.0), ("bgr", 0.0)):
        camera = {**policies.DESCRIPTION["cameras"][0], "color": color}
        folder = policies.write(tmp_path / color, policies.graph((0.0, 0.0, 0.0), red=1.0), cameras=[camera])
        with PolicyServer(VLARunner.from_pretrained(folder)) as server:
            assert VLARunner.from_pretrained(server.address).predict(red, "go")[0] == pytest.approx(ahead)


WRONG = [
    ({}, "the policy takes observation.images.camera 12x16x3; got nothing"),
    ({"observation.images.camera": np.zeros((12, 16, 4), np.uint8)}, "got observation.images.camera 12x16x4"),
    ({"observation.images.camera": np.zeros((12, 16, 3), np.float32)}, "must be uint8, got float32"),
    ({"observation.images.camera": np.zeros((12, 16, 3), np.uint8)}, "instruction: this policy needs one"),
    ({"observation.images.camera": np.zeros((12, 16, 3), np.uint8), "prompt": 3}, "prompt must be a text, got int"),
]


def test_what_clients_do_wrong_is_one_sentence(runner: VLARunner) -> None:
    with PolicyServer(runner) as server, connect(server.address, compression=None) as client:
        assert wire.unpack(client.recv())["format"] == "3we-policy"
        for observation, message in WRONG:
            client.send(wire.pack(observation))
            assert message in str(client.recv())
        for garbage in (b"", b"\xc1", b"\x93", msgpack.packb([1]), b"\x91" * 5000):
            client.send(garbage)
            assert isinstance(client.recv(), str)
        client.send("text")
        assert "expected an observation" in str(client.recv())
        right = {"observation.images.camera": np.zeros((12, 16, 3), np.uint8), "prompt": "go"}
        client.send(wire.pack(right))
        assert wire.unpack(client.recv())["actions"].shape == (policies.CHUNK, 3)  # it serves on


def test_pages_of_browsers_are_refused(runner: VLARunner) -> None:
    with PolicyServer(runner) as server, pytest.raises(InvalidStatus, match="403"):
        connect(server.address, origin="http://evil.example")  # type: ignore[arg-type]


def test_a_port_that_is_taken(runner: VLARunner) -> None:
    with PolicyServer(runner) as server, pytest.raises(ConfigError, match="cannot listen there"):
        PolicyServer(runner, port=int(server.address.rpartition(":")[2]))


ARRAY = {b"__ndarray__": True, b"dtype": "<f4", b"shape": [2, 3], b"data": bytes(24)}


@pytest.mark.parametrize(
    "changes",
    [
        {b"dtype": "|O"},
        {b"dtype": "V8"},
        {b"shape": [2**30, 2**30]},
        {b"shape": [-2, -3]},
        {b"data": bytes(20)},
        {b"data": 3},
    ],
)
def test_arrays_that_lie_are_refused(changes: dict[bytes, Any]) -> None:
    assert wire.unpack(msgpack.packb(ARRAY)).shape == (2, 3)
    with pytest.raises(ValueError, match="no message of openpi's protocol"):
        wire.unpack(msgpack.packb({**ARRAY, **changes}))


ABOUT = {**policies.DESCRIPTION}
RIGHT = {"actions": np.full((policies.CHUNK, 3), 0.1, np.float32)}


def fault(kind: str) -> Callable[[Any], None]:
    """A server that is right three times."""

    def talk(connection: Any) -> None:
        connection.send(wire.pack(ABOUT))
        for _ in range(3):
            connection.recv()
            connection.send(wire.pack(RIGHT))
        connection.recv()
        if kind == "gone":
            connection.socket.close()
        elif kind == "late":
            time.sleep(1.5)
        elif kind == "garbage":
            connection.send(b"\xc1" * 100)
        elif kind == "huge":
            connection.send(bytes(wire.LARGEST + 1))
        elif kind == "error":
            connection.send("Traceback\nRuntimeError: broken")
        elif kind == "empty":
            connection.send(wire.pack({}))
        else:
            wrong = {"shape": np.zeros((2, 3), np.float32), "nan": np.full((policies.CHUNK, 3), np.nan, np.float32)}
            connection.send(wire.pack({"actions": wrong[kind]}))
        time.sleep(0.2)

    return talk


FAULTS = {
    "gone": "broke off",
    "late": "no answer within",
    "garbage": "no message of openpi's protocol",
    "huge": "broke off",
    "error": "the server says: RuntimeError: broken",
    "empty": "answered without 'actions'",
    "shape": "",
    "nan": "",
}


@pytest.mark.parametrize("kind", list(FAULTS))
def test_faults_of_the_server_end_a_run_as_policy_error(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(remote, "PATIENCE", 0.4)

    async def drive(address: str) -> Any:
        runner = VLARunner.from_pretrained(address)
        async with Robot(image_size=SIZE) as robot:
            result = await runner.run(robot, "go to the chair", timeout=5.0)
            await robot.move_forward(0.1)  # usable at once
            return result

    with served(fault(kind)) as address:
        result = asyncio.run(drive(address))
    assert result.reason == "policy_error"
    assert FAULTS[kind] in result.detail


def test_a_server_that_came_back_is_asked_again(runner: VLARunner) -> None:
    picture = np.zeros((*SIZE, 3), np.uint8)
    with PolicyServer(runner) as server:
        far = VLARunner.from_pretrained(server.address)
        port = int(server.address.rpartition(":")[2])
    far._engine._close()  # type: ignore[attr-defined]
    with pytest.raises(ConnectionError, match="no policy server"):
        far.predict(picture, "go")
    with PolicyServer(runner, port=port):
        assert far.predict(picture, "go") == pytest.approx(runner.predict(picture, "go"), abs=1e-6)


def test_a_server_that_came_back_with_another_policy_is_not(runner: VLARunner, tmp_path: Path) -> None:
    picture = np.zeros((*SIZE, 3), np.uint8)
    with PolicyServer(runner) as server:
        far = VLARunner.from_pretrained(server.address)
        port = int(server.address.rpartition(":")[2])
    far._engine._close()  # type: ignore[attr-defined]
    faster = VLARunner.from_pretrained(policies.write(tmp_path / "faster", rate=20))
    with PolicyServer(faster, port=port):
        for _ in range(2):
            with pytest.raises(ConnectionError, match="serves another policy than before: load it anew"):
                far.predict(picture, "go")


def test_a_server_that_says_nothing_of_itself_needs_names() -> None:
    seen: list[Any] = []

    def talk(connection: Any) -> None:
        connection.send(wire.pack({}))
        while True:
            seen.append(wire.unpack(connection.recv()))
            connection.send(wire.pack({"actions": np.tile([1.0, 90.0], (4, 1)), "server_timing": {"infer_ms": 1.0}}))

    rename: dict[str, Any] = {
        "observation/image": "camera",
        "observation/state": ["vx"],
        "actions": ["vx", "theta.vel"],
    }
    with served(talk) as address:
        far = VLARunner.from_pretrained(address, rename=rename, rate=15)
        assert (far.policy.chunk, far.policy.rate, far.policy.kinematics.name) == (4, 15, "differential")
        red = np.zeros((224, 224, 3), np.uint8)
        red[:, :, 2] = 255  # BGR
        assert far.predict(red, "pick it up", velocity=Velocity(0.3, 0, 0)) == pytest.approx([1, 0, np.pi / 2])
        assert set(seen[-1]) == {"observation/image", "observation/state", "prompt"}
        assert seen[-1]["observation/image"][0, 0].tolist() == [255, 0, 0]  # RGB
        assert seen[-1]["observation/state"].tolist() == pytest.approx([0.3])
        assert seen[-1]["prompt"] == "pick it up"
        for options, message in (
            ({}, "does not say what it takes and gives.*rename="),
            ({"rename": rename}, "does not say"),
            ({"rename": {**rename, "actions": ["vx", "third"]}, "rate": 15}, "'actions' has 'third'"),
            (
                {"rename": {**rename, "actions": ["vx", "vy", "omega"]}, "rate": 15},
                r"gives actions \(4, 2\); rename= names 3",
            ),
        ):
            with pytest.raises(ConfigError, match=message):
                VLARunner.from_pretrained(address, **options)


def test_addresses_that_are_none(runner: VLARunner) -> None:
    with pytest.raises(ConnectionError, match=r"no policy server: .*threewe policy serve"):
        VLARunner.from_pretrained("ws://127.0.0.1:9")
    with pytest.raises(ConfigError, match="no address; expected ws://host:port"):
        VLARunner.from_pretrained("ws://")
    with pytest.raises(ConfigError, match=r"leave out python=, dataset= and revision="):
        VLARunner.from_pretrained("ws://127.0.0.1:9", python="python")
    with PolicyServer(runner) as server, pytest.raises(ConfigError, match="describes itself: leave out rename="):
        VLARunner.from_pretrained(server.address, rate=10)


DESCRIPTIONS: list[tuple[bytes, type[Exception], str]] = [
    (b"\xc1", ConnectionError, "no policy server: no message of openpi's protocol"),
    (msgpack.packb(3), ConnectionError, "it describes itself as '3'"),
    (wire.pack({**ABOUT, "version": 2}), ConfigError, "version: 2 is newer"),
    (wire.pack({**ABOUT, "cameras": []}), ConfigError, "cameras: must be a list"),
]


@pytest.mark.parametrize(("description", "kind", "message"), DESCRIPTIONS)
def test_descriptions_that_are_none(description: bytes, kind: type[Exception], message: str) -> None:
    with served(lambda connection: connection.send(description)) as address, pytest.raises(kind, match=message):
        VLARunner.from_pretrained(address)
