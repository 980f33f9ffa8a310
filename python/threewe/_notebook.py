"""How scans, maps and images look in notebooks: pictures as SVG, which follow the notebook's light or dark colours.

Nothing but numpy is needed. Text and lines are drawn in `currentColor`, the notebook's own.
"""

from __future__ import annotations

import base64
import importlib
import math
import struct
import sys
import zlib
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from threewe._colors import INK, UNKNOWN, Color, depth_colors, map_colors
from threewe._core import LaserScan, OccupancyGrid, RGBDImage, Sample, SemanticImage
from threewe.errors import ContractError

FREE = (255, 255, 255, 255)
HITS, SEEN = "#e0701c", "#f0a030"
TEXT = 'font-family="system-ui,sans-serif" font-size="12" fill="currentColor"'
SCALE_WIDTH = 66  # [px] of the scale next to a depth image
LINE = 'stroke="currentColor" fill="none"'


def show(*things: object) -> None:
    """Shows images, scans and maps at once in a notebook; elsewhere prints what they are.

    An image is (H, W, 3) uint8 BGR, as cameras give it; a depth image is (H, W) float32 [m], 0 where invalid.

    Raises:
        ContractError: an array of another shape or type.
    """
    pictures = [Picture(thing) if isinstance(thing, np.ndarray) else thing for thing in things]
    display = _notebook_display() or print
    for picture in pictures:
        display(picture)


class Picture:
    """An image as a notebook shows it: colour as it is, depth with its scale."""

    def __init__(self, pixels: NDArray[np.generic]) -> None:
        is_color = pixels.ndim == 3 and pixels.shape[2] == 3 and pixels.dtype == np.uint8
        is_depth = pixels.ndim == 2 and pixels.dtype == np.float32
        if not (is_color or is_depth) or not pixels.size:
            raise ContractError(
                f"an image is (H, W, 3) uint8 BGR or (H, W) float32 depth in metres, not {pixels.shape} {pixels.dtype}"
            )
        self._pixels = pixels

    def __repr__(self) -> str:
        height, width = self._pixels.shape[:2]
        return f"Picture({width} x {height}, {'colour' if self._pixels.ndim == 3 else 'depth'})"

    def _repr_html_(self) -> str:
        height, width = self._pixels.shape[:2]
        if self._pixels.ndim == 3:
            scale = min(1.0, 640 / width)
            return _page(_color(self._pixels, scale), (scale * width, scale * height), f"{width} x {height}")
        return _depth_page(np.asarray(self._pixels, np.float32))


def scan_html(scan: LaserScan) -> str:
    """A scan from above, ahead upwards: what it sees, range rings, the sensor in the middle."""
    size, middle = 340, 170.0
    ranges = np.asarray(scan.ranges, np.float64)
    valid, hit = ranges > 0.0, (ranges > 0.0) & (ranges < scan.range_max)
    reach = 1.05 * max(ranges[hit].max(initial=0.0), 1.0)
    scale = (middle - 14) / reach

    angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
    shown = scale * np.minimum(ranges, reach)
    points = np.stack([middle - shown * np.sin(angles), middle - shown * np.cos(angles)], axis=1)
    seen = " ".join(f"{x:.1f},{y:.1f}" for x, y in points[valid])
    dots = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in points[hit])

    step = _nice(reach / 2)
    radii = [step * i for i in range(1, math.floor(reach / step) + 1)]
    rings = "".join(
        f'<circle cx="{middle}" cy="{middle}" r="{scale * r:.1f}" {LINE} stroke-opacity=".22"/>'
        f'<text x="{middle + 0.71 * scale * r + 2:.1f}" y="{middle + 0.71 * scale * r + 10:.1f}" {TEXT} '
        f'opacity=".65">{r:g} m</text>'
        for r in radii
    )
    drawing = (
        f'<polygon points="{seen}" fill="{SEEN}" fill-opacity=".16"/>{rings}'
        f'<path d="{dots}" stroke="{HITS}" stroke-width="3.4" stroke-linecap="round" fill="none"/>'
        f'<path d="M{middle} {middle - 9}l6 15l-6 -4l-6 4z" fill="currentColor"/>'
    )
    invalid = len(ranges) - int(valid.sum())
    nearest = f"nearest {ranges[hit].min():.2f} m" if hit.any() else "nothing in range"
    caption = [
        f"{len(ranges)} beams, {int(hit.sum())} hits" + (f", {invalid} invalid" if invalid else ""),
        f"{nearest}, range {scan.range_min:g} to {scan.range_max:g} m",
    ]
    return _page(drawing, (size, size), *caption)


def rgbd_html(image: RGBDImage | SemanticImage) -> str:
    """Colour and depth side by side."""
    if image.depth is None:
        return Picture(image.color)._repr_html_()
    height, width = image.depth.shape
    scale = min(1.0, 400 / width)
    drawing = _color(image.color, scale) + _depth(image.depth, scale * width + 10, scale)
    return _page(
        drawing, (2 * scale * width + 10 + SCALE_WIDTH, scale * height), f"{width} x {height}, colour and depth"
    )


def map_html(grid: OccupancyGrid) -> str:
    """A map with north upwards, its frame's axes where its origin is, a scale bar and what the colours mean."""
    if not grid.data.size:
        return _page("", (0, 0), "an empty map")
    wide, high = grid.width * grid.resolution, grid.height * grid.resolution
    scale = min(560 / wide, 420 / high)
    width, height = scale * wide, scale * high

    # the axes of the map's frame, half a metre long and never too small to be seen
    x, y = -grid.origin[0] * scale, height + grid.origin[1] * scale
    arm = max(0.5 * scale, 14.0)
    axes = (
        f'<path d="M{x:.1f} {y:.1f}h{arm:.1f}" stroke="#d33" stroke-width="2"/>'
        f'<path d="M{x:.1f} {y:.1f}v{-arm:.1f}" stroke="#2a2" stroke-width="2"/>'
    )
    bar = _nice(wide / 4)
    swatches = ((FREE, "free"), (UNKNOWN, "unknown"), (INK, "occupied"))
    left = bar * scale + 60
    legend = "".join(
        f'<rect x="{left + 78 * i:.1f}" y="{height + 9:.1f}" width="12" height="12" fill="{_css(color)}" '
        f'stroke="currentColor" stroke-opacity=".4"/><text x="{left + 78 * i + 18:.1f}" y="{height + 19:.1f}" {TEXT}>'
        f"{name}</text>"
        for i, (color, name) in enumerate(swatches)
    )
    drawing = (
        _image(map_colors(grid), 0, 0, width, height)
        + f'<rect width="{width:.1f}" height="{height:.1f}" {LINE} stroke-opacity=".3"/>'
        + (axes if 0 <= x <= width and 0 <= y <= height else "")
        + f'<path d="M1 {height + 10:.1f}v10m0 -5h{bar * scale:.1f}m0 -5v10" {LINE} stroke-width="1.5"/>'
        + f'<text x="{bar * scale + 8:.1f}" y="{height + 19:.1f}" {TEXT}>{bar:g} m</text>'
        + legend
    )
    known = np.count_nonzero(grid.data != -1) * grid.resolution**2
    caption = (
        f"{wide:.1f} x {high:.1f} m, {grid.width} x {grid.height} cells of {grid.resolution:g} m, {known:.1f} m² known"
    )
    return _page(drawing, (max(width, left + 3 * 78), height + 26), caption)


def sample_html(sample: Sample) -> str | None:
    """A reading with its stamps, where there is a picture of it."""
    draw = getattr(sample.data, "_repr_html_", None)
    stamps = f"measured at {sample.measured:.3f} s, received at {sample.received:.3f} s"
    return None if draw is None else f'{draw()}<div style="font-size:12px;opacity:.75">{stamps}</div>'


def png(pixels: NDArray[np.uint8]) -> bytes:
    """A PNG file of (H, W, 3) RGB or (H, W, 4) RGBA pixels."""
    height, width, channels = pixels.shape
    differences = pixels.copy()
    differences[:, 1:] -= pixels[:, :-1]  # to the left: PNG's filter 1, which photographs need
    rows = np.ones((height, 1 + width * channels), np.uint8)
    rows[:, 1:] = differences.reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8, {3: 2, 4: 6}[channels], 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 6)), (b"IEND", b""))
    body = b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )
    return b"\x89PNG\r\n\x1a\n" + body


def _notebook_display() -> Callable[[object], object] | None:
    """What displays things in the notebook that runs this program; None elsewhere."""
    notebook = sys.modules.get("IPython")
    if notebook is None or notebook.get_ipython() is None:
        return None
    display: Callable[[object], object] = importlib.import_module("IPython.display").display
    return display


def _color(bgr: NDArray[np.generic], scale: float) -> str:
    """Here BGR becomes RGB."""
    rgb = np.asarray(bgr[..., ::-1], np.uint8)
    return _image(rgb, 0, 0, scale * rgb.shape[1], scale * rgb.shape[0], pixelated=False)


def _depth_page(depth: NDArray[np.float32]) -> str:
    height, width = depth.shape
    scale = min(1.0, 640 / width)
    return _page(_depth(depth, 0, scale), (scale * width + SCALE_WIDTH, scale * height), f"{width} x {height}")


def _depth(depth: NDArray[np.float32], x: float, scale: float) -> str:
    """A depth image and its scale at the right."""
    height, width = depth.shape
    valid = depth[depth > 0.0]
    low, high = (float(valid.min()), float(valid.max())) if valid.size else (0.0, 0.0)
    shown_width, shown_height = scale * width, scale * height
    bar = np.linspace(high, low, 64, dtype=np.float32)[:, np.newaxis]
    labels = "".join(
        f'<text x="{x + shown_width + 24:.1f}" y="{top:.1f}" {TEXT}>{value:.1f} m</text>'
        for value, top in ((high, 12.0), ((low + high) / 2, shown_height / 2 + 4), (low, shown_height - 3))
    )
    return (
        _image(depth_colors(depth, low, high), x, 0, shown_width, shown_height)
        + f'<rect x="{x:.1f}" width="{shown_width:.1f}" height="{shown_height:.1f}" {LINE} stroke-opacity=".3"/>'
        + _image(depth_colors(bar, low, high), x + shown_width + 8, 0, 10, shown_height, pixelated=False)
        + labels
    )


def _page(drawing: str, size: tuple[float, float], *caption: str) -> str:
    width, height = size
    lines = "".join(f"<div>{line}</div>" for line in caption)
    return (
        '<div style="display:inline-block;line-height:1.45">'
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.1f} {height:.1f}" style="max-width:100%;height:auto">{drawing}</svg>'
        f'<div style="font-size:12px;opacity:.75">{lines}</div></div>'
    )


def _image(pixels: NDArray[np.uint8], x: float, y: float, width: float, height: float, pixelated: bool = True) -> str:
    data = base64.b64encode(png(pixels)).decode()
    style = ' style="image-rendering:pixelated"' if pixelated else ""
    return (
        f'<image x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" preserveAspectRatio="none"'
        f'{style} href="data:image/png;base64,{data}"/>'
    )


def _css(color: Color) -> str:
    return "#" + "".join(f"{c:02x}" for c in color[:3])


def _nice(length: float) -> float:
    """The largest of 1, 2, 5, 10, ... times a power of ten that is no longer than this."""
    power = 10.0 ** math.floor(math.log10(length))
    steps: Sequence[float] = (5.0, 2.0, 1.0)
    return next(step * power for step in steps if step * power <= length * (1 + 1e-9))


# The types are made in C++; how they look in a notebook is Python's affair.
for _type, _draw in (
    (LaserScan, scan_html),
    (OccupancyGrid, map_html),
    (RGBDImage, rgbd_html),
    (SemanticImage, rgbd_html),
    (Sample, sample_html),
):
    setattr(_type, "_repr_html_", _draw)  # noqa: B010 (mypy knows the type without it)
