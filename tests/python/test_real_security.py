"""DDS security: with an enclave of SROS2 a robot is driven only by those who prove who they are."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import threewe.sync
from keystore import Keystore
from real_robot import FIRST_DOMAIN, PROGRAM
from threewe import ConfigError, ConnectionError, _core

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = ROOT / "build/dev/tests/ros2"
SERVE = "from threewe.cli import main; main()"

pytestmark = [
    pytest.mark.skipif(not PROGRAM.exists(), reason="the stand-ins need libfastrtps-dev and fastddsgen"),
    pytest.mark.flaky(reruns=1),  # as in test_real.py
]


@pytest.fixture(scope="module")
def keystore(tmp_path_factory: pytest.TempPathFactory) -> Keystore:
    made = Keystore(tmp_path_factory.mktemp("keystore"))
    for name in ("threewe", "robot", "alice"):
        made.add(name)
    return made


@pytest.fixture(autouse=True)
def network(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(FIRST_DOMAIN))
    for name in ("ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY", "ROS_SECURITY_ENABLE"):
        monkeypatch.delenv(name, raising=False)
    return monkeypatch


def variables(keystore: Keystore, enclave: str) -> dict[str, str]:
    return {
        "ROS_SECURITY_ENABLE": "true",
        "ROS_SECURITY_STRATEGY": "Enforce",
        "ROS_SECURITY_KEYSTORE": str(keystore.folder),
        "ROS_SECURITY_ENCLAVE_OVERRIDE": f"/{enclave}",
    }


def secure(network: pytest.MonkeyPatch, keystore: Keystore, enclave: str) -> None:
    for name, value in variables(keystore, enclave).items():
        network.setenv(name, value)


def test_a_peer_without_keys_neither_sees_nor_drives(
    network: pytest.MonkeyPatch, keystore: Keystore, tmp_path: Path
) -> None:
    served = [sys.executable, "-c", SERVE, "ros2", "serve"]
    environment = os.environ | variables(keystore, "robot")
    with subprocess.Popen(served, stdout=subprocess.PIPE, text=True, env=environment) as simulator:
        assert simulator.stdout is not None
        assert simulator.stdout.readline().startswith("serving ")

        assert [endpoint for endpoint in _core.ros2_discover(3.0).endpoints if endpoint.topic.startswith("/")] == []
        with pytest.raises(ConnectionError, match=r"cannot be reached|no ROS 2 node was found"):
            threewe.sync.Robot("real").connect()
        topics = ["/odom=nav_msgs::msg::dds_::Odometry_", "--drive", "/cmd_vel"]
        command = [str(PROGRAMS / "ros2_recorder"), str(FIRST_DOMAIN), str(tmp_path / "record"), *topics]
        done = subprocess.run(command, input="0.3 0 0 50\n", capture_output=True, text=True, timeout=60)
        assert done.stdout == "not matched\n"
        assert (tmp_path / "record").read_bytes() == b""

        secure(network, keystore, "threewe")
        with threewe.sync.Robot("real") as robot:
            assert robot.move_forward(0.3).success
        simulator.terminate()


def test_messages_of_all_types_reach_a_secured_peer_on_another_dds(keystore: Keystore, tmp_path: Path) -> None:
    """Ours is 'alice': by the hash of that name it is we who begin, which Fast DDS of this age needs."""
    domain = str(FIRST_DOMAIN + 1)
    names = {kind.split("/")[-1]: kind for kind in _core.ros2_message_types()}
    dds = {name: "{}::{}::dds_::{}_".format(*kind.split("/")) for name, kind in names.items()}
    topics = [f"/types/{name}={kind}" for name, kind in dds.items()]
    echo = [str(PROGRAMS / "ros2_recorder"), domain, str(tmp_path / "record"), "--echo", *topics]
    folder = keystore.folder / "enclaves" / "robot"
    corpus = ROOT / "tests/fuzz/corpus/message"
    with subprocess.Popen(
        echo, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, env=os.environ | {"THREEWE_TEST_ENCLAVE": str(folder)}
    ) as other:
        done = subprocess.run(
            [PROGRAMS / "ros2_exchange", domain, corpus],
            capture_output=True,
            text=True,
            timeout=60,
            env=os.environ | variables(keystore, "alice"),
        )
        other.terminate()
    assert done.stdout == f"{len(names)} of {len(names)} types\n", done


@pytest.mark.nightly
def test_a_handshake_that_cannot_succeed_is_named(
    network: pytest.MonkeyPatch, keystore: Keystore, tmp_path: Path
) -> None:
    """By the hashes of 'robot' and 'threewe' it is Fast DDS that begins."""
    network.setenv("ROS_DOMAIN_ID", str(FIRST_DOMAIN + 1))
    other = [str(PROGRAMS / "ros2_recorder"), str(FIRST_DOMAIN + 1), str(tmp_path / "record"), "--echo"]
    secured = os.environ | {"THREEWE_TEST_ENCLAVE": str(keystore.folder / "enclaves" / "robot")}
    topics = ["/odom=nav_msgs::msg::dds_::Odometry_"]
    with subprocess.Popen([*other, *topics], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, env=secured) as recorder:
        secure(network, keystore, "threewe")
        with pytest.raises(ConnectionError, match="begun by a key in a form that Cyclone DDS does not read"):
            threewe.sync.Robot("real").connect()
        recorder.terminate()


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("ROS_SECURITY_ENABLE", "yes", "ROS_SECURITY_ENABLE is 'yes'; it must be true or false"),
        ("ROS_SECURITY_KEYSTORE", "", "ROS_SECURITY_KEYSTORE names no folder of keys"),
        ("ROS_SECURITY_ENCLAVE_OVERRIDE", "/no_such_robot", "has no enclave '/no_such_robot': there is no folder"),
        ("ROS_SECURITY_ENCLAVE_OVERRIDE", "robot", "must be a name such as /robot"),
        ("ROS_SECURITY_ENCLAVE_OVERRIDE", "/../robot", "must be a name such as /robot"),
    ],
)
def test_variables_that_are_wrong_are_named(
    network: pytest.MonkeyPatch, keystore: Keystore, name: str, value: str, words: str
) -> None:
    secure(network, keystore, "threewe")
    network.setenv(name, value)
    with pytest.raises(ConfigError, match=words):
        threewe.sync.Robot("real").connect()


def connecting(network: pytest.MonkeyPatch, keystore: Keystore, enclave: str) -> str:
    """What is said of an enclave that is not accepted."""
    secure(network, keystore, enclave)
    with pytest.raises((ConfigError, ConnectionError)) as raised:
        threewe.sync.Robot("real").connect()
    text = str(raised.value)
    print(enclave, text)
    assert f"the security enclave '/{enclave}'" in text
    return text


def test_files_that_are_wrong_are_each_their_own_error(
    network: pytest.MonkeyPatch, keystore: Keystore, tmp_path: Path
) -> None:
    (keystore.add("lacking") / "key.pem").unlink()
    assert "has no key.pem, in " in connecting(network, keystore, "lacking")
    keystore.add("expired", days=-1)
    assert "expired" in connecting(network, keystore, "expired").split("\n", 1)[1].lower()
    (keystore.add("malformed") / "cert.pem").write_text("no certificate")
    assert "certificate" in connecting(network, keystore, "malformed").split("\n", 1)[1]
    folder = keystore.add("tampered")
    text = (folder / "permissions.p7s").read_text()
    (folder / "permissions.p7s").write_text(text.replace("rt/*", "*"))
    assert "PKCS7" in connecting(network, keystore, "tampered").split("\n", 1)[1]
    other = Keystore(tmp_path / "other").add("stranger")
    folder = keystore.add("stranger")
    (folder / "cert.pem").write_bytes((other / "cert.pem").read_bytes())
    (folder / "key.pem").write_bytes((other / "key.pem").read_bytes())
    assert "signature failure" in connecting(network, keystore, "stranger")
