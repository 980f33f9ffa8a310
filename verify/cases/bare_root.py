"""A root folder with a Python, the libraries which that Python links, libstdc++, and nothing else of this machine.

There is no compiler in it, no shell, and no library that a wheel could find by chance.
"""

import shutil
import subprocess
from pathlib import Path

# shows the folders up to -- in the root $1, for itself alone (a mount name space), and runs the rest in there
SCRIPT = """
root=$1; shift
while [ "$1" != -- ]; do mkdir -p "$root$1"; mount --rbind "$1" "$root$1"; shift; done; shift
cd /; exec chroot "$root" "$@"
"""
UNSHARE = ["unshare", "--mount", "--map-root-user"]
ENVIRONMENT = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/tmp", "COLUMNS": "200"}
# what every Linux for manylinux wheels has: the C library in its parts, and the C++ library
PROMISED = {
    f"lib{name}" for name in ("c.so.6", "m.so.6", "pthread.so.0", "dl.so.2", "rt.so.1", "util.so.1", "mvec.so.1")
}
PROMISED |= {"libstdc++.so.6", "libgcc_s.so.1"}


def missing() -> str | None:
    """What this machine lacks for one, if anything."""
    able = shutil.which("unshare") and subprocess.run([*UNSHARE, "true"], capture_output=True).returncode == 0
    return None if able else "an empty root needs `unshare` and leave to mount in a name space of one's own"


class BareRoot:
    """The root around a virtual environment that `python -m venv --copies` has made."""

    def __init__(self, folder: Path, venv: Path) -> None:
        """Fills a folder that does not exist yet."""
        self.folder = folder
        self.venv = venv
        ask = [venv / "bin/python", "-c", "import sysconfig; print(sysconfig.get_path('stdlib'))"]
        self.standard_library = Path(subprocess.check_output(ask, text=True).strip())
        (folder / "tmp").mkdir(parents=True)
        parts = [path for path in self.standard_library.glob("lib-dynload/*.so") if "tkinter" not in path.name]
        promised = {library for library in links(*venv.glob("lib/**/*.so")) if library.name in PROMISED}
        for library in links(venv / "bin/python", *parts) | promised:
            place = folder / library.relative_to("/")
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(library, place)

    def run(self, *arguments: str | Path) -> dict[str, int | str]:
        """Runs the Python in there: its exit status, and all that it printed."""
        shown = [self.standard_library, self.venv]
        command = [*UNSHARE, "sh", "-euc", SCRIPT, "-", self.folder, *shown, "--", self.venv / "bin/python", *arguments]
        done = subprocess.run(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=ENVIRONMENT, cwd="/"
        )
        return {"status": done.returncode, "out": done.stdout}


def links(*programs: Path) -> set[Path]:
    """The shared libraries that programs need and the loader finds here, itself included."""
    listing = subprocess.run(["ldd", *programs], capture_output=True, text=True).stdout.splitlines()
    return {Path(word) for line in listing if line.startswith("\t") for word in line.split() if word.startswith("/")}
