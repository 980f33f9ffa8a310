"""How a contact sheet is drawn: a row an episode."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageOps

from threewe import drawing as d
from threewe._colors import Color
from threewe._core import Pose2D, RobotProfile, Scene

# [px]
MARGIN, GAP, HEADER = 32, 12, 92
TEXT_WIDTH, FRAME_WIDTH, FRAME_HEIGHT, MAP_WIDTH = 232, 224, 168, 264
LINE_LENGTH = 24  # letters of a task

SUCCEEDED: Color = (46, 140, 84, 255)
FAILED: Color = (200, 62, 54, 255)
FAINT: Color = (120, 124, 134, 255)
EDGE: Color = (206, 204, 198, 255)
RULE: Color = (226, 224, 218, 255)
WALL: Color = (92, 98, 112, 255)
AROUND = 1.2  # [m] that a map shows beyond the trajectory, and ...
LEAST = 4.0  # [m] ... its height at least
OUTSIDE = 0.25  # [m] that a map shows around a scene
SCAN_HEIGHT = 8.0  # [m] that a picture of a scan shows


@dataclass
class EpisodeRow:
    """What is shown of an episode."""

    title: str
    task: str
    success: bool | None
    robot: str
    seconds: float
    times: list[float]  # [s] of the images, since the episode's start
    images: list[Image.Image]  # RGB
    path: NDArray[np.float64]  # (N, 3) [m, m, rad] in the scene, or in `map` where that is None
    scene: Scene | None
    profile: RobotProfile | None
    walls: NDArray[np.float64]  # (N, 2) [m] where lidar saw some
    note: str

    @property
    def driven(self) -> float:
        """[m]"""
        return float(np.linalg.norm(np.diff(self.path[:, :2], axis=0), axis=1).sum())


def draw_sheet(name: str, rows: Sequence[EpisodeRow], total: int) -> Image.Image:
    """All rows under a heading; `total` episodes are there."""
    columns = max((len(row.images) for row in rows), default=0)
    has_maps = any(len(row.path) for row in rows)
    width = 2 * MARGIN + TEXT_WIDTH + columns * (FRAME_WIDTH + GAP) + (MAP_WIDTH if has_maps else -GAP)
    sheet = Image.new("RGB", (width, HEADER + len(rows) * (FRAME_HEIGHT + 2 * GAP) + MARGIN), d.PAPER[:3])
    _draw_heading(sheet, name, rows, total)
    for i, row in enumerate(rows):
        top = HEADER + i * (FRAME_HEIGHT + 2 * GAP)
        ImageDraw.Draw(sheet).line([MARGIN, top, width - MARGIN, top], RULE, 1)
        _draw_text(sheet, row, top + GAP)
        for k, (time, image) in enumerate(zip(row.times, row.images, strict=True)):
            left = MARGIN + TEXT_WIDTH + k * (FRAME_WIDTH + GAP)
            sheet.paste(_framed(image, time), (left, top + GAP))
        if len(row.path):
            left = MARGIN + TEXT_WIDTH + columns * (FRAME_WIDTH + GAP)
            sheet.paste(_rounded(_draw_map(row, (MAP_WIDTH, FRAME_HEIGHT))), (left, top + GAP))
    return sheet


def draw_scan(points: NDArray[np.float64], lidar: Pose2D, profile: RobotProfile | None, width: int) -> Image.Image:
    """What the lidar saw, (N, 2) [m] in the base frame; the robot looks up."""
    height = SCAN_HEIGHT * FRAME_HEIGHT / FRAME_WIDTH
    view = d.View((-SCAN_HEIGHT / 2, -height / 2), (SCAN_HEIGHT / 2, height / 2), width / SCAN_HEIGHT)
    picture = Image.new("RGB", view.size, (255, 255, 255))
    up = np.stack([-points[:, 1], points[:, 0]], axis=1)
    d.draw_rays(picture, view, (-lidar.y, lidar.x), up)
    _draw_robot(picture, view, Pose2D(0.0, 0.0, np.pi / 2), profile)
    return d.finish(picture)


def _draw_heading(sheet: Image.Image, name: str, rows: Sequence[EpisodeRow], total: int) -> None:
    draw = ImageDraw.Draw(sheet)
    draw.text((MARGIN, 24), name, d.INK, d.text_font(26))
    words = [f"{total} episode{'s' * (total != 1)}"]
    if len(rows) < total:
        words.append(f"{len(rows)} shown")
    words.append(", ".join(sorted({row.robot for row in rows if row.robot})))
    words.append(f"{sum(row.seconds for row in rows):.0f} s")
    words.append(f"{sum(row.driven for row in rows):.1f} m driven" if any(len(row.path) for row in rows) else "")
    judged = [row.success for row in rows if row.success is not None]
    words.append(f"{sum(judged)} of {len(judged)} succeeded" if judged else "")
    draw.text((MARGIN, 58), "  ·  ".join(word for word in words if word), FAINT, d.text_font(14))


def _draw_text(sheet: Image.Image, row: EpisodeRow, top: int) -> None:
    """Title, task, and how it went."""
    draw = ImageDraw.Draw(sheet)
    draw.text((MARGIN, top + 2), row.title, d.INK, d.text_font(18))
    lines = textwrap.wrap(row.task or "no task", LINE_LENGTH, max_lines=4, placeholder=" ...")
    for i, line in enumerate(lines):
        draw.text((MARGIN, top + 32 + 19 * i), line, d.INK if row.task else FAINT, d.text_font(14))
    length = f"{row.seconds:.1f} s" + (f"  ·  {row.driven:.1f} m" if len(row.path) else "")
    draw.text((MARGIN, top + FRAME_HEIGHT - 54), length, FAINT, d.text_font(14))
    word, color = {None: ("not judged", FAINT), True: ("succeeded", SUCCEEDED), False: ("failed", FAILED)}[row.success]
    right = _draw_badge(sheet, word, color, (MARGIN, top + FRAME_HEIGHT - 28))
    if row.note:
        _draw_badge(sheet, row.note, d.HITS, (right + 8, top + FRAME_HEIGHT - 28))


def _draw_badge(sheet: Image.Image, word: str, color: Color, corner: tuple[int, int]) -> int:
    """A word on a rounded patch; its right edge [px]."""
    font = d.text_font(13)
    width, height = round(font.getlength(word)) + 20, 24
    patch = _patch((width, height), height // 2, (*color[:3], 36))
    sheet.paste(patch, corner, patch)
    ImageDraw.Draw(sheet).text((corner[0] + width / 2, corner[1] + height / 2), word, color, font, anchor="mm")
    return corner[0] + width


def _framed(image: Image.Image, time: float) -> Image.Image:
    """An image cut to the frame, with its time."""
    frame = ImageOps.fit(image.convert("RGB"), (FRAME_WIDTH, FRAME_HEIGHT), Image.Resampling.LANCZOS)
    word, font = f"{time:.1f} s", d.text_font(12)
    width = round(font.getlength(word)) + 12
    patch = _patch((width, 20), 6, (*d.INK[:3], 170))
    left, top = FRAME_WIDTH - width - 6, FRAME_HEIGHT - 26
    frame.paste(patch, (left, top), patch)
    ImageDraw.Draw(frame).text((left + width / 2, top + 10), word, (255, 255, 255), font, anchor="mm")
    return _rounded(frame)


def _patch(size: tuple[int, int], radius: int, color: Color) -> Image.Image:
    """A smooth rounded rectangle."""
    big = Image.new("RGBA", (4 * size[0], 4 * size[1]), (*color[:3], 0))
    ImageDraw.Draw(big).rounded_rectangle([0, 0, big.width - 1, big.height - 1], 4 * radius, color)
    return big.reduce(4)


def _rounded(image: Image.Image) -> Image.Image:
    """The image on paper, its corners round, with a thin edge."""
    framed = Image.new("RGB", image.size, d.PAPER[:3])
    edge = _patch(image.size, 8, EDGE)
    framed.paste(edge, (0, 0), edge)
    inner = image.crop((1, 1, image.width - 1, image.height - 1))
    framed.paste(inner, (1, 1), _patch(inner.size, 7, d.INK).getchannel("A"))
    return framed


def _draw_map(row: EpisodeRow, size: tuple[int, int]) -> Image.Image:
    """The trajectory from above: a ring where it began, the robot where it ended."""
    view = _view_around(row.path[:, :2], size, row.scene)
    if row.scene is not None:
        picture = d.draw_scene(row.scene, view, labels=False)
    else:
        picture = Image.new("RGB", view.size, (255, 255, 255))
        draw = ImageDraw.Draw(picture)
        for x, y in view.points(row.walls):
            draw.ellipse([x - 1, y - 1, x + 1, y + 1], WALL)
    d.draw_path(picture, view, row.path[:, :2], d.TRAJECTORY, 4.0 / view.scale)
    draw = ImageDraw.Draw(picture)
    x, y = view.point(*row.path[0, :2])
    r = 6 * d.SUPERSAMPLING
    draw.ellipse([x - r, y - r, x + r, y + r], (255, 255, 255), d.TRAJECTORY[:3], 3 * d.SUPERSAMPLING)
    _draw_robot(picture, view, Pose2D(*row.path[-1]), row.profile)
    return d.finish(picture).resize(size)


def _draw_robot(picture: Image.Image, view: d.View, pose: Pose2D, profile: RobotProfile | None) -> None:
    """Its outline, or a disc where its profile is not known."""
    if profile is not None:
        d.draw_robot(picture, view, pose, profile)
        return
    x, y = view.point(pose.x, pose.y)
    r = 8 * d.SUPERSAMPLING
    ImageDraw.Draw(picture).ellipse([x - r, y - r, x + r, y + r], d.BODY, d.INK, d.SUPERSAMPLING)


def _view_around(path: NDArray[np.float64], size: tuple[int, int], scene: Scene | None) -> d.View:
    """All of a path and something around it, as large as the picture allows; of what is outside of a scene little."""
    low, high = path.min(axis=0) - AROUND, path.max(axis=0) + AROUND
    middle = (low + high) / 2
    height = max(float(high[1] - low[1]), float(high[0] - low[0]) * size[1] / size[0], LEAST)
    half = np.array([height * size[0] / size[1], height]) / 2
    if scene is not None:
        first, last = np.array(scene.min) - OUTSIDE + half, np.array(scene.max) + OUTSIDE - half
        middle = np.where(first <= last, np.clip(middle, first, np.maximum(first, last)), (first + last) / 2)
    (left, bottom), (right, top) = (middle - half).tolist(), (middle + half).tolist()
    return d.View((left, bottom), (right, top), size[1] / height)
