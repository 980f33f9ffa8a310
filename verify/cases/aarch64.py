"""Builds a verify program for 64-bit Arm, and says how to run it here."""

import functools
import shutil
import subprocess
from pathlib import Path

from verify.cases.trees import ROOT, build, configure

TREE = ROOT / "build" / "aarch64"
LIBRARIES = TREE / "root" / "usr" / "lib" / "aarch64-linux-gnu"
EMULATOR = "qemu-aarch64"
ENVIRONMENT = {"QEMU_LD_PREFIX": "/usr/aarch64-linux-gnu", "QEMU_SET_ENV": f"LD_LIBRARY_PATH={LIBRARIES}"}
PACKAGES = [
    "libyaml-cpp-dev",
    "libyaml-cpp0.7",
    "libfmt-dev",
    "libfmt9",
    "libhwy-dev",
    "libhwy1",
    "libpugixml-dev",
    "libpugixml1v5",
    "libzstd-dev",
    "libzstd1",
]


def missing() -> str | None:
    """What this machine lacks, if anything."""
    lacks = [tool for tool in (EMULATOR, "aarch64-linux-gnu-g++", "apt-get", "dpkg-deb") if shutil.which(tool) is None]
    return f"aarch64 needs {', '.join(lacks)}" if lacks else None


@functools.cache
def program(name: str) -> Path:
    """The program, built when it is out of date."""
    return build(TREE, name, make_tree)


def fetch_libraries() -> None:
    """Debian's libraries for that processor, unpacked beside the build: nothing is installed."""
    (TREE / "lists" / "partial").mkdir(parents=True, exist_ok=True)
    apt = ["apt-get", "-qq"]
    for option in (
        "APT::Architecture=arm64",
        "APT::Architectures=arm64",
        f"Dir::State::Lists={TREE / 'lists'}",
        "Debug::NoLocking=1",
        "APT::Sandbox::User=root",
    ):
        apt += ["-o", option]
    subprocess.run([*apt, "update"], check=True)
    subprocess.run([*apt, "download", *PACKAGES], check=True, cwd=TREE)
    for package in TREE.glob("*.deb"):
        subprocess.run(["dpkg-deb", "-x", package, TREE / "root"], check=True)


def make_tree() -> None:
    """A build tree for that processor, against those libraries."""
    if not LIBRARIES.exists():
        fetch_libraries()
    settings = {
        "CMAKE_BUILD_TYPE": "Release",
        "CMAKE_SYSTEM_NAME": "Linux",
        "CMAKE_SYSTEM_PROCESSOR": "aarch64",
        "CMAKE_CXX_COMPILER": "aarch64-linux-gnu-g++",
        "CMAKE_LIBRARY_ARCHITECTURE": "aarch64-linux-gnu",
        "CMAKE_FIND_ROOT_PATH": f"{TREE / 'root'};/usr",
        "CMAKE_FIND_ROOT_PATH_MODE_PROGRAM": "NEVER",
        # what g++ 12 for this processor suspects, and that for others does not
        "CMAKE_CXX_FLAGS": "-Wno-error=null-dereference -Wno-error=maybe-uninitialized",
        "CMAKE_EXE_LINKER_FLAGS": f"-Wl,-rpath-link,{LIBRARIES}",
        "THREEWE_CYCLONEDDS_INCLUDE_DIR": "",  # without the backend `real`: nothing emulated asks for it
    }
    configure(TREE, settings, {"PKG_CONFIG_LIBDIR": f"{LIBRARIES}/pkgconfig:/usr/share/pkgconfig"})
