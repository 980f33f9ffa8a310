"""python -m verify.cases.packet_relay A B [--delay S] [--jitter S] [--loss SHARE] [--twice SHARE]

Connects two network namespaces by a link that delays, loses, reorders and doubles packets: kernels need no netem for
it. Each gets a device whose other end is here, with the address 10.77.0.1 or 10.77.0.2. Needs root. It prints a line
when it is ready. A line of its input says how many changed copies follow each datagram from A to B from then on. It
ends with its input, and prints how many there were.
"""

import argparse
import contextlib
import fcntl
import heapq
import os
import random
import select
import struct
import subprocess
import sys
import time

TUNSETIFF = 0x400454CA
TUN_WITHOUT_HEADER = 0x1001
LARGEST = 65536
UDP = 28
"""[bytes] of the headers of a datagram."""
MOST = 1472
"""[bytes] of a datagram that is no fragment."""
EXTREMES = [b"\xff" * 4, b"\xff\xff\xff\x7f", b"\0\0\0\x80", b"\0" * 4, b"\xff" * 8, b"\x01\0\0\0", b"\0\0"]


def make_device(name: str, namespace: str, address: str) -> int:
    """A device of that namespace, whose packets are read and written here."""
    device = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(device, TUNSETIFF, struct.pack("16sH22x", name.encode(), TUN_WITHOUT_HEADER))
    subprocess.run(["ip", "link", "set", name, "netns", namespace], check=True)
    for command in (
        f"address add {address}/24 dev {name}",
        f"link set {name} up",
        f"link set {name} multicast on",
        "link set lo up",
        f"route replace 224.0.0.0/4 dev {name}",
    ):
        subprocess.run(["ip", "-n", namespace, *command.split()], check=True)
    return device


def relay(devices: list[int], options: argparse.Namespace) -> None:
    """Until the input ends."""
    draw = random.Random(options.seed)
    due: list[tuple[float, int, int, bytes]] = []  # when, in which order, where to, what
    count = 0
    copies = changed = 0
    seen = [b"\0" * 64]  # datagrams, of which others get pieces
    while True:
        wait = max(0.0, due[0][0] - time.monotonic()) if due else None
        ready, _, _ = select.select([*devices, sys.stdin], [], [], wait)
        if sys.stdin in ready:
            line = sys.stdin.readline()
            if not line:
                print(changed, flush=True)
                return
            copies = int(line)
        for source, target in (devices, devices[::-1]):
            if source not in ready:
                continue
            packet = os.read(source, LARGEST)
            if copies and source == devices[0] and is_whole_datagram(packet):
                seen = [*seen[-200:], packet[UDP:]]
                for _ in range(copies):
                    changed += write(target, with_payload(packet, change(packet[UDP:], seen, draw)))
            for _ in range(1 + (draw.random() < options.twice)):
                if draw.random() < options.loss:
                    continue
                late = options.delay + draw.uniform(-1.0, 1.0) * options.jitter
                count += 1
                heapq.heappush(due, (time.monotonic() + late, count, target, packet))
        while due and due[0][0] <= time.monotonic():
            _, _, target, packet = heapq.heappop(due)
            write(target, packet)


def write(device: int, packet: bytes) -> bool:
    """Whether there was room for it in its queue: else it is lost."""
    with contextlib.suppress(BlockingIOError):
        os.write(device, packet)
        return True
    return False


# Changed packets


def is_whole_datagram(packet: bytes) -> bool:
    """UDP over IPv4 without options, and no fragment: those of large messages are left as they are."""
    return len(packet) > UDP and packet[0] == 0x45 and packet[9] == 17 and packet[6] & 0x3F == 0 and packet[7] == 0


def with_payload(packet: bytes, payload: bytes) -> bytes:
    """The same datagram with another content."""
    size = UDP + len(payload)
    header = bytearray(packet[:UDP])
    header[2:4] = struct.pack(">H", size)
    header[10:12] = b"\0\0"
    total = sum(struct.unpack(">10H", header[:20]))
    while total >> 16:
        total = (total & 0xFFFF) + (total >> 16)
    header[10:12] = struct.pack(">H", ~total & 0xFFFF)
    header[24:28] = struct.pack(">HH", size - 20, 0)  # 0: without a sum of its own
    return bytes(header) + payload


def change(payload: bytes, seen: list[bytes], draw: random.Random) -> bytes:
    """One to six changes: of bits, bytes, words and lengths, or of pieces that are lost, doubled or from elsewhere.

    What marks a packet as RTPS is mostly left, as nothing else is read of one without.
    """
    data = bytearray(payload)
    for _ in range(draw.randint(1, 6)):
        first = min(0 if draw.random() < 0.02 else 4, len(data) - 1)
        at = draw.randrange(first, len(data))
        kind = draw.randrange(8)
        if kind == 0:
            data[at] ^= 1 << draw.randrange(8)
        elif kind == 1:
            data[at] = draw.randrange(256)
        elif kind == 2:
            word = draw.choice(EXTREMES)
            data[at : at + len(word)] = word
        elif kind == 3 and len(data) > 24:  # the kind, the flags or the length of the first submessage
            data[20 + draw.randrange(4)] = draw.randrange(256)
        elif kind == 4:
            del data[at + 1 :]
        elif kind == 5:
            data[at:at] = data[at : at + draw.randrange(64)]
        elif kind == 6:
            other = draw.choice(seen)
            begin = draw.randrange(len(other))
            data[at : at + 64] = other[begin : begin + 64]
        else:
            del data[at : at + draw.randrange(1, 16)]
        if not data:
            data = bytearray(payload[:4])
    return bytes(data[:MOST])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("namespaces", nargs=2)
    for name in ("delay", "jitter", "loss", "twice"):
        parser.add_argument(f"--{name}", type=float, default=0.0)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    pid = os.getpid() % 100000
    devices = [
        make_device(f"we{pid}{end}", namespace, f"10.77.0.{end}")
        for end, namespace in enumerate(options.namespaces, start=1)
    ]
    print("ready", flush=True)
    relay(devices, options)


if __name__ == "__main__":
    main()
