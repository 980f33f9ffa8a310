"""Pictures of scenes, maps and robots, seen from above."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFilter, ImageFont

from threewe import OccupancyGrid, Pose2D, RobotProfile, Scene
from threewe._colors import INK as INK
from threewe._colors import UNKNOWN as UNKNOWN
from threewe._colors import Color, map_colors

Points = Sequence[tuple[float, float]] | NDArray[np.float64]

PAPER: Color = (250, 249, 246, 255)
TRAJECTORY: Color = (52, 116, 219, 255)
PLAN: Color = (226, 62, 120, 255)
RAYS: Color = (255, 190, 40, 70)
HITS: Color = (214, 96, 20, 255)
BODY: Color = (255, 122, 46, 255)
# bodies, ways and goals of several robots
TEAM: list[Color] = [BODY, TRAJECTORY, (46, 160, 92, 255), (140, 84, 200, 255)]

FLOORS: dict[str, Color] = {
    "wood": (236, 222, 196, 255),
    "tile": (225, 232, 233, 255),
    "carpet": (220, 224, 236, 255),
    "concrete": (228, 226, 221, 255),
    "vinyl": (231, 233, 222, 255),
    "grass": (206, 226, 184, 255),
    "gravel": (222, 213, 196, 255),
    "asphalt": (203, 204, 208, 255),
    "paving": (224, 221, 212, 255),
}
FURNITURE: dict[str, Color] = {
    "chair": (94, 129, 172, 255),
    "desk": (190, 144, 96, 255),
    "table": (201, 160, 112, 255),
    "shelf": (150, 117, 90, 255),
    "plant": (98, 158, 96, 255),
    "couch": (176, 104, 112, 255),
    "refrigerator": (196, 206, 214, 255),
    "monitor": (70, 76, 88, 255),
    "bed": (168, 150, 190, 255),
    "cabinet": (164, 134, 110, 255),
    "counter": (208, 200, 188, 255),
    "door": (206, 140, 78, 255),
    "box": (205, 168, 112, 255),
    "cup": (214, 74, 66, 255),
    "tree": (84, 142, 84, 255),
    "column": (150, 152, 158, 255),
}
PATCH: Color = (70, 90, 160, 40)
ROUTE: Color = (170, 60, 160, 255)
TREETOPS = 2.0  # [m]: what begins above is drawn so that one sees what is below

# Everything is drawn at twice its final size and halved at the end: Pillow's own lines are not smooth.
SUPERSAMPLING = 2


@dataclass
class View:
    """Which part of the plane a picture shows. `scale` is in final pixels per metre; y points up."""

    min: tuple[float, float]
    max: tuple[float, float]
    scale: float
    pixels: float = field(init=False)

    def __post_init__(self) -> None:
        self.pixels = self.scale * SUPERSAMPLING

    @classmethod
    def of(cls, scene: Scene, width: int, margin: float = 0.4) -> View:
        """The whole scene and a margin [m], `width` final pixels wide."""
        low = (scene.min[0] - margin, scene.min[1] - margin)
        high = (scene.max[0] + margin, scene.max[1] + margin)
        return cls(low, high, width / (high[0] - low[0]))

    @property
    def size(self) -> tuple[int, int]:
        """Of the picture while it is drawn: even, so that it can be halved."""
        width, height = (round((self.max[i] - self.min[i]) * self.scale) for i in (0, 1))
        return SUPERSAMPLING * (width + width % 2), SUPERSAMPLING * (height + height % 2)

    def point(self, x: float, y: float) -> tuple[float, float]:
        """Where (x, y) [m] lies in the picture while it is drawn."""
        return (x - self.min[0]) * self.pixels, (self.max[1] - y) * self.pixels

    def points(self, points: Points) -> list[tuple[float, float]]:
        """As `point`, for many."""
        return [self.point(float(x), float(y)) for x, y in points]


def draw_scene(scene: Scene, view: View, labels: bool = True) -> Image.Image:
    """The true scene, RGB: floors, furniture, walls and the names of its rooms."""
    picture = Image.new("RGBA", view.size, PAPER)
    draw = ImageDraw.Draw(picture)
    for room in scene.rooms:
        draw.rectangle(
            [*view.point(room.min[0], room.max[1]), *view.point(room.max[0], room.min[1])], floor_color(room.floor)
        )
    picture = _draw_patches(picture, scene, view)
    picture = _draw_furniture(picture, scene, view)
    _draw_walls(picture, scene, view)
    for person in scene.people:
        draw_path(picture, view, [*person.route, person.route[0]], ROUTE, 0.03)
    if labels:
        _draw_labels(picture, scene, view)
    return picture.convert("RGB")


def draw_map(grid: OccupancyGrid, view: View) -> Image.Image:
    """A robot's own map, RGB: unknown grey, free white, occupied dark."""
    cells = Image.fromarray(map_colors(grid)).convert("RGB")

    # each cell becomes an axis-aligned patch; the picture's edge cuts off what lies outside the view
    picture = Image.new("RGB", view.size, UNKNOWN[:3])
    if cells.width and cells.height:
        left, bottom = view.point(*grid.origin)
        size = (round(cells.width * grid.resolution * view.pixels), round(cells.height * grid.resolution * view.pixels))
        picture.paste(cells.resize(size, Image.Resampling.NEAREST), (round(left), round(bottom) - size[1]))
    return picture


def draw_rays(picture: Image.Image, view: View, origin: tuple[float, float], hits: Points) -> None:
    """What the lidar sees: the area its rays cross, and the points they hit."""
    if len(hits) < 3:
        return
    # only the rays' own rectangle is blended: the rest of the picture stays as it is
    points = np.array([view.point(*origin), *view.points(hits)])
    corner = np.maximum(np.floor(points.min(axis=0)).astype(int) - 2, 0)
    size = np.minimum(np.ceil(points.max(axis=0)).astype(int) + 3, picture.size) - corner
    layer = Image.new("RGBA", (int(size[0]), int(size[1])))
    draw = ImageDraw.Draw(layer)
    start, *ends = [(x, y) for x, y in (points - corner).tolist()]
    draw.polygon(ends, RAYS)
    for end in ends[::6]:
        draw.line([start, end], (*RAYS[:3], 110), SUPERSAMPLING)
    r = 0.03 * view.pixels
    for x, y in ends:
        draw.ellipse([x - r, y - r, x + r, y + r], HITS)
    picture.paste(layer, (int(corner[0]), int(corner[1])), layer)


def draw_path(
    picture: Image.Image, view: View, path: Points, color: Color, width: float = 0.06, dashed: bool = False
) -> None:
    """A path [m] of some width [m]."""
    if len(path) < 2:
        return
    draw = ImageDraw.Draw(picture)
    points = view.points(path)
    pixels = max(1, round(width * view.pixels))
    if not dashed:
        draw.line(points, color, pixels, joint="curve")
        return
    dash = 0.22 * view.pixels
    for a, b in _dashes(points, dash):
        draw.line([a, b], color, pixels)
    x, y = points[-1]
    r = 0.16 * view.pixels
    draw.ellipse([x - r, y - r, x + r, y + r], outline=color, width=pixels)


def draw_robot(picture: Image.Image, view: View, pose: Pose2D, profile: RobotProfile, color: Color = BODY) -> None:
    """The robot's outline with a white arrow for its heading, drawn a little larger than life so that it is seen."""
    draw = ImageDraw.Draw(picture)
    grow = max(1.0, 20.0 / (view.scale * 2 * profile.footprint_radius))
    outline = [_transform(pose, grow * x, grow * y) for x, y in profile.footprint]
    draw.polygon(view.points(outline), color, INK, SUPERSAMPLING)
    r = grow * profile.footprint_radius
    arrow = [
        _transform(pose, *p) for p in ((0.62 * r, 0.0), (-0.3 * r, 0.4 * r), (-0.12 * r, 0.0), (-0.3 * r, -0.4 * r))
    ]
    draw.polygon(view.points(arrow), (255, 255, 255, 255))


def draw_goal(picture: Image.Image, view: View, goal: tuple[float, float], radius: float, color: Color = PLAN) -> None:
    """A disc [m] to arrive in, and its middle."""
    x, y = view.point(*goal)
    layer = Image.new("RGBA", picture.size)
    draw = ImageDraw.Draw(layer)
    r, dot, line = radius * view.pixels, max(0.09 * view.pixels, 4.0), max(2, round(0.03 * view.pixels))
    draw.ellipse([x - r, y - r, x + r, y + r], (*color[:3], 60), color, line)
    draw.ellipse([x - dot, y - dot, x + dot, y + dot], color, (255, 255, 255, 255), line)
    picture.paste(layer, (0, 0), layer)


def draw_person(picture: Image.Image, view: View, place: tuple[float, float], radius: float) -> None:
    """A person's head and shoulders."""
    draw = ImageDraw.Draw(picture)
    x, y = view.point(*place)
    for share, color in ((1.0, ROUTE), (0.5, (255, 226, 196, 255))):
        r = share * radius * view.pixels
        draw.ellipse([x - r, y - r, x + r, y + r], color, INK, SUPERSAMPLING)


def team_color(robot: int) -> Color:
    """Of one of several robots."""
    return TEAM[robot % len(TEAM)]


def finish(picture: Image.Image) -> Image.Image:
    """The picture at its final size, smooth."""
    return picture.reduce(SUPERSAMPLING)


def text_font(pixels: float) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Pillow's own font: there on every machine."""
    return ImageFont.load_default(size=pixels)


def floor_color(material: str) -> Color:
    """Of a floor, by its material."""
    return FLOORS.get(material, FLOORS["concrete"])


def furniture_color(category: str) -> Color:
    """Of an object, by its category."""
    return FURNITURE.get(category, (160, 160, 168, 255))


def _transform(pose: Pose2D, x: float, y: float) -> tuple[float, float]:
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    return pose.x + c * x - s * y, pose.y + s * x + c * y


def _draw_patches(picture: Image.Image, scene: Scene, view: View) -> Image.Image:
    """Floors of their own friction, in their own colour with a blue cast: the less friction, the deeper."""
    layer = Image.new("RGBA", picture.size)
    draw = ImageDraw.Draw(layer)
    for patch in scene.patches:
        corners = [*view.point(patch.min[0], patch.max[1]), *view.point(patch.max[0], patch.min[1])]
        ImageDraw.Draw(picture).rectangle(corners, floor_color(patch.floor))
        draw.rectangle(corners, (*PATCH[:3], round(PATCH[3] * max(0.2, 2.0 * (1.0 - patch.friction)))))
    picture.alpha_composite(layer)
    return picture


def _draw_furniture(picture: Image.Image, scene: Scene, view: View) -> Image.Image:
    shadow = Image.new("RGBA", picture.size)
    shapes = Image.new("RGBA", picture.size)
    offset = 0.05
    treetops = Image.new("RGBA", picture.size)
    # low parts first, so that a chair's back lies over its seat, a cup on its table; higher ones are a little lighter
    parts = [(prism, thing) for thing in scene.objects for prism in thing.prisms]
    for prism, thing in sorted(parts, key=lambda part: part[0].z_max):
        color = furniture_color(thing.category)
        outline = [_transform(thing.pose, *p) for p in prism.outline()]
        lift = min(1.0, prism.z_max / 1.5)
        shade = tuple(round(c + (255 - c) * 0.22 * lift) for c in color[:3])
        edge = tuple(round(0.72 * c) for c in color[:3])
        dropped = [(x + offset, y - offset) for x, y in outline]
        layer, opacity = (treetops, 120) if prism.z_min >= TREETOPS else (shapes, 255)
        ImageDraw.Draw(shadow).polygon(view.points(dropped), (20, 20, 30, 90))
        ImageDraw.Draw(layer).polygon(view.points(outline), (*shade, opacity), (*edge, opacity), SUPERSAMPLING)
    picture.alpha_composite(shadow.filter(ImageFilter.GaussianBlur(0.05 * view.pixels)))
    picture.alpha_composite(shapes)
    picture.alpha_composite(treetops)
    return picture


def _draw_walls(picture: Image.Image, scene: Scene, view: View) -> None:
    draw = ImageDraw.Draw(picture)
    for wall in scene.walls:
        (ax, ay), (bx, by) = wall.a, wall.b
        length = math.hypot(bx - ax, by - ay)
        nx, ny = -(by - ay) / length * wall.thickness / 2, (bx - ax) / length * wall.thickness / 2
        draw.polygon(view.points([(ax + nx, ay + ny), (bx + nx, by + ny), (bx - nx, by - ny), (ax - nx, ay - ny)]), INK)


def _draw_labels(picture: Image.Image, scene: Scene, view: View) -> None:
    draw = ImageDraw.Draw(picture)
    font = text_font(0.34 * view.pixels)
    for room in scene.rooms:
        name = room.name.replace("_", " ")
        draw.text(
            view.point(*room.anchor), name, INK, font, anchor="mm", stroke_width=3, stroke_fill=floor_color(room.floor)
        )


def _dashes(points: list[tuple[float, float]], dash: float) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Every second stretch of length `dash` along a polyline."""
    line = np.asarray(points)
    steps = np.hypot(*np.diff(line, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    starts = np.arange(0.0, along[-1], 2 * dash)

    def at(distance: float) -> tuple[float, float]:
        return float(np.interp(distance, along, line[:, 0])), float(np.interp(distance, along, line[:, 1]))

    return [(at(start), at(min(start + dash, float(along[-1])))) for start in starts.tolist()]
