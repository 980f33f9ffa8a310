"""What a camera sees, as pictures: colour, depth and semantics side by side."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from threewe import CameraIntrinsics, Scene, SemanticImage
from threewe import drawing as d
from threewe._colors import Color, depth_colors

GAP = 12  # [px]
FAR = 8.0  # [m], darkest
SURFACES: dict[str, Color] = {
    "nothing": (222, 236, 248, 255),
    "floor": (206, 200, 190, 255),
    "wall": (150, 158, 170, 255),
    "ceiling": (240, 240, 238, 255),
}
PERSON: Color = (220, 60, 140, 255)


def scaled(camera: CameraIntrinsics, width: int) -> CameraIntrinsics:
    """The same view with fewer pixels."""
    scale = width / camera.width
    fx, fy, cx, cy = (scale * value for value in (camera.fx, camera.fy, camera.cx, camera.cy))
    return CameraIntrinsics(width, round(scale * camera.height), fx, fy, cx, cy)


def strip(truth: SemanticImage, scene: Scene) -> Image.Image:
    """Colour, depth and semantics."""
    height, width = truth.ids.shape
    picture = Image.new("RGB", (3 * width + 2 * GAP, height), d.PAPER[:3])
    depth = depth_colors(truth.depth, 0.0, FAR)
    depth[truth.depth == 0.0] = SURFACES["nothing"]
    for i, pixels in enumerate((truth.color[..., ::-1], depth[..., :3], semantic_colors(truth, scene)[truth.ids])):
        picture.paste(Image.fromarray(np.ascontiguousarray(pixels)), (i * (width + GAP), 0))
    return picture


def semantic_colors(truth: SemanticImage, scene: Scene) -> NDArray[np.uint8]:
    """A colour for every id, (N, 3) RGB: that of its category, each thing a little lighter or darker than the next."""
    categories = {thing.name: thing.category for thing in scene.objects}
    people = {person.name for person in scene.people}
    colors = []
    for i, name in enumerate(truth.names):
        if name in SURFACES:
            color = np.array(SURFACES[name][:3], float)
        else:
            of_kind = (
                PERSON if name in people else d.furniture_color(categories[name]) if name in categories else d.BODY
            )
            color = np.array(of_kind[:3], float) * (0.82, 0.91, 1.0, 1.09)[i % 4]
        colors.append(color.clip(0, 255))
    return np.array(colors, np.uint8)


def things_in_sight(truth: SemanticImage) -> int:
    """How many things are seen well."""
    return int(np.count_nonzero(np.bincount(truth.ids.ravel()) > truth.ids.size / 400))


def as_jpeg(picture: Image.Image) -> bytes:
    """Compressed."""
    file = io.BytesIO()
    picture.save(file, "JPEG", quality=88)
    return file.getvalue()
