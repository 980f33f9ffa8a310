"""Maps as ROS keeps them: a picture, and a file that says where it lies."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from threewe._core import OccupancyGrid

OCCUPIED, FREE, UNKNOWN = 0, 254, 205  # grey values by which map_server's saver marks cells
OCCUPIED_THRESHOLD, FREE_THRESHOLD = 0.65, 0.25


def save_map(grid: OccupancyGrid, folder: Path) -> None:
    """Writes map.pgm and map.yaml into a folder, as `ros2 run nav2_map_server map_saver_cli` does."""
    data = np.asarray(grid.data)
    picture = np.full(data.shape, UNKNOWN, dtype=np.uint8)
    picture[data >= 100 * OCCUPIED_THRESHOLD] = OCCUPIED
    picture[(data >= 0) & (data <= 100 * FREE_THRESHOLD)] = FREE
    header = f"P5\n# written by threewe\n{grid.width} {grid.height}\n255\n".encode()
    (folder / "map.pgm").write_bytes(header + picture[::-1].tobytes())  # its first row is the highest y
    (folder / "map.yaml").write_text(
        f"image: map.pgm\nmode: trinary\nresolution: {grid.resolution:g}\n"
        f"origin: [{grid.origin[0]:.3f}, {grid.origin[1]:.3f}, 0]\nnegate: 0\n"
        f"occupied_thresh: {OCCUPIED_THRESHOLD}\nfree_thresh: {FREE_THRESHOLD}\n",
        encoding="utf-8",
    )
