"""What ways to a robot on ROS 2 carry: streams of images with commands, and packets between network namespaces."""

import bisect
import ctypes
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import threewe
import threewe.sync
from threewe import Pose2D

from verify.cases.real_robots import HARDWARE, MISSING, NAV2, PROGRAM
from verify.cases.trees import ROOT
from verify.harness import Case

STREAMS = ROOT / "build/dev/tests/ros2/ros2_streams"
TRAFFIC = ROOT / "build/dev/tests/ros2/ros2_traffic"
SECONDS = 10.0
"""Of each way of streaming."""
MESSAGES = ROOT / "tests/fuzz/corpus/message"
LINK = """
link:
  driver: ros2
  topics:
    lidar: {topic: /scan, type: sensor_msgs/msg/LaserScan}
    odometry: {topic: /odom, type: nav_msgs/msg/Odometry}
"""
CAMERA = """    camera: {topic: /camera/image_raw, type: sensor_msgs/msg/Image}
    depth: {topic: /camera/depth, type: sensor_msgs/msg/Image}
"""
COMMAND = """  command: {topic: /cmd_vel, type: geometry_msgs/msg/Twist}
  stops: {by: the stand-in, after: 0.2}
"""
SMALL_BUFFER = {
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",
    "CYCLONEDDS_URI": "<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast></General><Discovery>"
    "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
    '<Peers><Peer address="localhost"/></Peers></Discovery>'
    '<Internal><SocketReceiveBufferSize max="208kB"/></Internal></Domain></CycloneDDS>',
}
"""As a kernel is by default, whatever this one grants."""


def carry_streams(_seed: int) -> Case:
    """50 commands a second, with nothing but odometry and scans coming in; with two streams of images besides; and
    with a receive buffer that is too small for these.
    """
    if not STREAMS.exists():
        return MISSING
    idle = _stream("", [], {})
    full = _stream(CAMERA, ["--images"], {})
    small = _stream(CAMERA, ["--images"], SMALL_BUFFER)
    granted = int(Path("/proc/sys/net/core/rmem_max").read_text())
    return {
        "scan_latency": float(np.median(idle["latencies"])),
        "scan_latency_beside_images": float(np.median(full["latencies"])),
        "idle_jitter": idle["jitter"],
        "more_jitter": full["jitter"] - idle["jitter"],
        "images": full["images"],
        "lost": full["lost"],
        "granted": granted,
        "lost_of_small": small["lost"],
        "said_of_small": small["said"],
    }


def _stream(camera: str, options: list[str], environment: dict[str, str]) -> dict[str, Any]:
    domain = str(1 + os.getpid() % 100)
    environment = {**os.environ, "ROS_DOMAIN_ID": domain, **environment}
    with tempfile.TemporaryDirectory() as folder:
        profile = Path(folder) / "robot.yaml"
        text = (ROOT / "assets/robots/3we_depth_v2.yaml").read_text()
        profile.write_text(text + LINK + camera + COMMAND)
        with subprocess.Popen([STREAMS, domain, *options], stdout=subprocess.PIPE, text=True) as sender:
            assert sender.stdout is not None
            sender.stdout.readline()
            command = [TRAFFIC, profile, str(SECONDS)]
            got = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=SECONDS + 40.0)
            sender.terminate()
            sent = json.loads(sender.communicate(timeout=30)[0])
    if got.returncode != 0:  # it may not even have connected
        return {"latencies": [math.inf], "jitter": math.inf, "images": 0, "lost": math.inf, "said": got.stderr}
    received = json.loads(got.stdout)
    latencies, _ = _matched(sent["scans"], received["scans"])
    _, lost = _matched(sent["images"], received["images"])
    intervals = np.diff(sent["commands"])[2:-5] * 1e-9  # without how it begins and ends
    return {
        "latencies": latencies,
        "jitter": float(np.percentile(np.abs(intervals - 0.02), 99)),
        "images": len(received["images"]),
        "lost": lost,
        "said": received["fault"],
    }


def _matched(sent: list[int], received: list[tuple[int, int]]) -> tuple[list[float], int]:
    """How long each was on its way [s], and how many are missing in between, of numbers that count to 1,024."""
    latencies = []
    found: list[int] = []
    for number, at in received:
        newest = bisect.bisect_right(sent, at) - 1
        index = newest - (newest - number) % 1024
        found.append(index)
        latencies.append((at - sent[index]) * 1e-9)
    return latencies, found[-1] - found[0] + 1 - len(found) if found else 0


# What others read


def run_test(_seed: int, test: str) -> Case:
    """One of the tests, as a case: it compares values, and brings its own programs."""
    if not PROGRAM.exists():
        return MISSING
    command = [sys.executable, "-m", "pytest", "-q", f"tests/python/{test}"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    return {"ok": done.returncode == 0 and "1 passed" in done.stdout, "said": done.stdout[-2000:]}


def read_payloads(seed: int, message: str, inputs: int) -> Case:
    """Changed payloads of one type, under sanitizers: see tests/fuzz/message_fuzzer.cpp."""
    program = ROOT / "build/fuzz/tests/fuzz/message_fuzzer"
    if not program.exists():
        return {"not_shown": "the fuzzers are not built: `./dev fuzz` builds them"}
    with tempfile.TemporaryDirectory() as folder:
        command = [program, folder, f"-runs={inputs}", f"-seed={seed % 2**31}", f"-seed_inputs={MESSAGES / message}"]
        environment = {
            **os.environ,
            "THREEWE_FUZZ_MESSAGE": message,
            "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1",
            "UBSAN_OPTIONS": "halt_on_error=1:print_stacktrace=1",
        }
        command += ["-max_len=16384", "-rss_limit_mb=3072", f"-artifact_prefix={folder}/"]
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", env=environment)
    return {"message": message, "ok": done.returncode == 0, "said": done.stderr[-2000:]}


# Packets


@contextmanager
def namespaces(*options: str) -> Iterator[tuple[str, str, "subprocess.Popen[str]"]]:
    """Two network namespaces, with a link in between and who relays its packets: see packet_relay.py. This process goes
    into the second.
    """
    names = f"we{os.getpid()}a", f"we{os.getpid()}b"
    home = os.open("/proc/self/ns/net", os.O_RDONLY)
    relay = None
    try:
        for name in names:
            subprocess.run(["ip", "netns", "add", name], check=True)
        command = [sys.executable, "-m", "verify.cases.packet_relay", *names, *options]
        relay = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT)
        assert relay.stdout is not None
        if relay.stdout.readline() != "ready\n":
            raise RuntimeError("the relay did not begin")
        with Path(f"/run/netns/{names[1]}").open() as namespace:
            _enter(namespace.fileno())
        yield *names, relay
    finally:
        _enter(home)
        if relay is not None and relay.poll() is None:
            relay.communicate(timeout=30)
        for name in names:
            subprocess.run(["ip", "netns", "delete", name], check=False)


def _enter(namespace: int) -> None:
    """Threads that are made from now on are there as well."""
    if ctypes.CDLL(None, use_errno=True).setns(namespace, 0x40000000) != 0:
        raise OSError(ctypes.get_errno(), "setns")


def no_network_of_its_own() -> Case | None:
    """What keeps a case from being shown here that needs a stand-in and a link of our own; None where nothing does."""
    if not PROGRAM.exists():
        return MISSING
    if os.geteuid() != 0 or not Path("/dev/net/tun").exists():
        return {"not_shown": "namespaces with a link of our own need root and /dev/net/tun"}
    return None


def drive_over_packets(seed: int, delegated: bool) -> Case:
    """1 m there and back over a link whose packets are late by 20 +- 10 ms, overtake each other, and of which 1 % are
    lost and 1 % come twice; by us, or by the stand-in for Nav2 on the robot's side.
    """
    if cannot := no_network_of_its_own():
        return cannot
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SUBNET"
    os.environ["ROS_DOMAIN_ID"] = domain = "1"
    link = ["--delay", "0.02", "--jitter", "0.01", "--loss", "0.01", "--twice", "0.01", "--seed", str(seed % 2**31)]
    results = []
    with namespaces(*link) as (theirs, _, _):

        def start(*command: str) -> "subprocess.Popen[str]":
            inside = ["ip", "netns", "exec", theirs, *command]
            return subprocess.Popen(inside, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

        base = start(str(PROGRAM), domain, "--truth", "--seed", str(seed % 1000))
        nav2 = start(str(NAV2), domain) if delegated else None  # which commands the robot, too
        time.sleep(1.0)
        programs = {"localization": "slam_toolbox", "navigation": "nav2"} if delegated else {}
        with threewe.sync.Robot("real", HARDWARE, **programs) as robot:
            for x in (1.0, 0.0):
                result = robot.move_to(x, 0.0)
                results.append({"reason": result.reason.name, "detail": result.detail})
            robot.sleep(0.5)
            base.terminate()  # while it is still there: it returns to its start once it is let go
            truth = json.loads(base.communicate(timeout=30)[0].splitlines()[-1])
        if nav2 is not None:
            nav2.communicate(timeout=30)
    pose = Pose2D(*truth["pose"])
    return {
        "results": results,
        "arrived": all(one["reason"] == "reached" for one in results) and math.hypot(pose.x, pose.y) <= 0.35,
        "contact_speed": truth["max_collision_speed"],
    }


def attack(seed: int, seconds: float) -> Case:
    """Drives in a circle, in a process of its own, while ten changed copies follow each packet that comes from the
    robot: of what it measures, of how nodes find each other and of what is acknowledged.
    """
    if cannot := no_network_of_its_own():
        return cannot
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SUBNET"
    os.environ["ROS_DOMAIN_ID"] = domain = "1"
    with namespaces("--seed", str(seed % 2**31)) as (theirs, _, relay), ExitStack() as ending:
        base = subprocess.Popen(
            ["ip", "netns", "exec", theirs, str(PROGRAM), domain, "--seed", str(seed % 1000)],
            stdout=subprocess.PIPE,
            text=True,
        )
        ending.callback(base.kill)
        command = [sys.executable, "-m", "verify.cases.attacked_robot"]
        with subprocess.Popen(
            command,
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="backslashreplace",  # the DDS library names what it is sent, in the sender's own bytes
        ) as robot:
            assert robot.stdin is not None
            assert robot.stdout is not None
            assert relay.stdin is not None
            began = robot.stdout.readline() == "drives\n"
            for copies in ("10", "0") if began else ():
                relay.stdin.write(f"{copies}\n")
                relay.stdin.flush()
                time.sleep(seconds if copies != "0" else 1.0)
            out, error = robot.communicate(timeout=60)
        packets = relay.communicate(timeout=30)[0]
        time.sleep(1.0)
        base.terminate()
        truth = json.loads(base.communicate(timeout=30)[0].splitlines()[-1])
    said = json.loads(out.splitlines()[-1]) if out else {"grown": math.inf, "said": ""}
    return {
        "ended": robot.returncode,
        "packets": int(packets),
        "grown": said["grown"],
        "said": said["said"] or error[-1000:],
        "speed": truth["speed"],
        "contact_speed": truth["max_collision_speed"],
    }
