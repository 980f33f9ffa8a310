"""A dataset's folder changes at once or not at all: it is written beside, synchronized, and renamed."""

from __future__ import annotations

import ctypes
import os
import shutil
import tempfile
from pathlib import Path

from threewe.data.lerobot.places import inside
from threewe.errors import ConfigError

AT_FDCWD = -100
RENAME_EXCHANGE = 2


def require_free(root: Path) -> None:
    """Raises ConfigError where a dataset, or anything else, has this name already."""
    if root.is_symlink() or root.exists():
        raise ConfigError(f"{root}: exists already; choose another name, or append to it")


def working_folder(root: Path) -> Path:
    """A folder beside `root` to write in, on the same file system."""
    parent = root.absolute().parent
    parent.mkdir(parents=True, exist_ok=True)
    return Path(tempfile.mkdtemp(dir=parent, prefix=f".{root.name}.partial-"))


def linked_folder(root: Path) -> Path:
    """A folder beside a dataset with links to its files, to add files to; those in `meta` are copies, to be changed.

    Raises ConfigError for links that lead out of it, and what is no file.
    """
    folder = working_folder(root)
    try:
        for where, _, names in os.walk(root):
            below = Path(where).relative_to(root)
            (folder / below).mkdir(exist_ok=True)
            for name in names:
                file = inside(root, (below / name).as_posix())
                link_or_copy(file, folder / below / name, copy=below.parts[:1] == ("meta",))
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return folder


def state_of(root: Path) -> tuple[int, ...]:
    """Differs after each change of a dataset."""
    found = (root / "meta/info.json").stat()
    return found.st_dev, found.st_ino, found.st_mtime_ns, found.st_size


def link_or_copy(file: Path, to: Path, *, copy: bool) -> None:
    """Where a file system has no hard links, a copy."""
    if not copy:
        try:
            to.hardlink_to(file)
            return
        except OSError:
            pass
    shutil.copyfile(file, to)


def replace_folder(folder: Path, root: Path) -> None:
    """Gives a complete folder the name `root`; one that was there is removed afterwards."""
    folder.chmod(0o755)
    synchronize(folder)
    if not root.exists():
        folder.rename(root)
    elif exchange(folder, root):
        shutil.rmtree(folder)
    else:  # a file system without that: for a moment the old one has another name
        old = folder.with_name(folder.name.replace(".partial-", ".old-"))
        root.rename(old)
        folder.rename(root)
        shutil.rmtree(old)
    synchronize_entry(root.absolute().parent)


def exchange(folder: Path, root: Path) -> bool:
    """Swaps two folders in one step; false where the system cannot."""
    rename = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if rename is None:
        return False
    return bool(rename(AT_FDCWD, os.fsencode(folder), AT_FDCWD, os.fsencode(root), RENAME_EXCHANGE) == 0)


def synchronize(folder: Path) -> None:
    """Waits until a folder's contents are on the disk."""
    for where, _, names in os.walk(folder):
        for name in names:
            synchronize_entry(Path(where) / name)
        synchronize_entry(Path(where))


def synchronize_entry(path: Path) -> None:
    """Waits until a file, or a folder's list of names, is on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
