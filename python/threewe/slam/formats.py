"""Which reader takes which file."""

from __future__ import annotations

from pathlib import Path

from threewe.slam.carmen import read_carmen
from threewe.slam.log import Log, Progress


def read_log(path: Path, *, on_progress: Progress | None = None) -> Log:
    """Reads a CARMEN log; a journal, or a folder of one; or a rosbag2, which is another folder or a file that ends in
    .db3 or .mcap. Raises ConfigError.
    """
    if path.suffix == ".journal" or (path.is_dir() and any(path.glob("*.journal"))):
        from threewe.slam.journal import read_journal

        return read_journal(path, on_progress=on_progress)
    if path.is_dir() or path.suffix in (".db3", ".mcap"):
        from threewe.slam.rosbag import read_rosbag  # needs an extra

        return read_rosbag(path, on_progress=on_progress)
    return read_carmen(path, on_progress=on_progress)
