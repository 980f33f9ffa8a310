"""How the viewer's window is laid out."""

from __future__ import annotations

import rerun.blueprint as rrb

from threewe import Scene
from threewe._colors import UNKNOWN, Color

TIMELINE = "robot_time"

# From the beginning to the moment that is looked at: paths are streamed piece by piece, this joins them.
SO_FAR = rrb.VisibleTimeRanges(
    timeline=TIMELINE, start=rrb.TimeRangeBoundary.infinite(), end=rrb.TimeRangeBoundary.cursor_relative()
)
BACKGROUND: Color = (24, 28, 36, 255)


def layout(scene: Scene | None, camera: bool, depth: bool) -> rrb.Blueprint:
    """The world and the robot's map, its pictures where it has a camera, and its signals over time."""
    pictures = [
        rrb.Spatial2DView(origin="map/camera", contents=f"$origin/{kind}", name=kind)
        for kind, there in (("color", camera), ("depth", depth))
        if there
    ]
    return rrb.Blueprint(
        rrb.Vertical(
            rrb.Horizontal(
                _world(scene),
                rrb.Vertical(
                    _map(scene, 0.85 if pictures else 1.2),
                    *([rrb.Horizontal(*pictures)] if pictures else []),
                    row_shares=[3, 2],
                ),
                column_shares=[3, 2],
            ),
            rrb.Horizontal(
                rrb.TimeSeriesView(origin="signals/velocity", name="velocity [m/s, rad/s]"),
                rrb.TimeSeriesView(origin="signals/battery", name="battery [%]"),
                *([rrb.TimeSeriesView(origin="signals/error", name="localisation error [m]")] if scene else []),
            ),
            row_shares=[3, 1],
        ),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE),
        collapse_panels=True,
    )


def stage(scene: Scene) -> rrb.Blueprint:
    """The world alone."""
    return rrb.Blueprint(_world(scene), rrb.TimePanel(state="collapsed", timeline=TIMELINE), collapse_panels=True)


def _world(scene: Scene | None) -> rrb.Spatial3DView:
    """All there is, seen from the south and from above."""
    x, y, span = _extent(scene)
    eye = rrb.EyeControls3D(position=(x, y - 0.66 * span, 0.77 * span), look_target=(x, y, 0.0))
    return _spatial("world" if scene else "robot", ["+ /**"], BACKGROUND, eye)


def _map(scene: Scene | None, distance: float) -> rrb.Spatial3DView:
    """What the robot knows, seen from straight above; `distance` in widths of the scene."""
    x, y, span = _extent(scene)
    eye = rrb.EyeControls3D(position=(x, y, distance * span), look_target=(x, y, 0.0), eye_up=(0.0, 1.0, 0.0))
    return _spatial("map", ["+ map/**", "- map/camera/**", "+ scene/true_path"], UNKNOWN, eye)


def _spatial(name: str, contents: list[str], background: Color, eye: rrb.EyeControls3D) -> rrb.Spatial3DView:
    return rrb.Spatial3DView(
        name=name,
        contents=contents,
        background=background,
        line_grid=False,
        eye_controls=eye,
        overrides={"scene/true_path": SO_FAR, "map/estimated_path": SO_FAR},
    )


def _extent(scene: Scene | None) -> tuple[float, float, float]:
    """Middle and longer side [m] of what is looked at."""
    if scene is None:
        return 0.0, 0.0, 12.0
    width, depth = scene.max[0] - scene.min[0], scene.max[1] - scene.min[1]
    return (scene.min[0] + scene.max[0]) / 2, (scene.min[1] + scene.max[1]) / 2, max(width, depth)
