"""What notebooks show: read back pixel by pixel and point by point."""

from __future__ import annotations

import base64
import io
import math
import re
import sys
import types
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
import threewe
from numpy.typing import NDArray
from PIL import Image
from threewe import LaserScan, OccupancyGrid, Robot
from threewe._notebook import Picture, png

SVG = "{http://www.w3.org/2000/svg}"


def page_of(thing: object) -> ElementTree.Element:
    """The HTML, which is also XML."""
    html = thing._repr_html_()  # type: ignore[attr-defined]
    return ElementTree.fromstring(html)


def drawing_of(thing: object) -> ElementTree.Element:
    drawing = page_of(thing).find(f"{SVG}svg")
    assert drawing is not None
    return drawing


def text_of(thing: object) -> str:
    return " | ".join(page_of(thing).itertext())


def images_of(thing: object) -> list[tuple[ElementTree.Element, NDArray[np.uint8]]]:
    images = drawing_of(thing).findall(f"{SVG}image")
    encoded = [image.attrib["href"].removeprefix("data:image/png;base64,") for image in images]
    return [
        (image, np.array(Image.open(io.BytesIO(base64.b64decode(data)))))
        for image, data in zip(images, encoded, strict=True)
    ]


def points_of(thing: object) -> NDArray[np.float64]:
    """Where the hits of a scan are drawn, relative to the sensor: x to the right, y upwards."""
    sensor, hits = None, np.empty((0, 2))
    for path in drawing_of(thing).findall(f"{SVG}path"):
        if "h0" in path.attrib["d"] or not path.attrib["d"]:
            found = re.findall(r"M([\d.-]+) ([\d.-]+)h0", path.attrib["d"])
            hits = np.array(found, np.float64).reshape(-1, 2)
        else:
            x, y = (float(v) for v in re.match(r"M([\d.]+) ([\d.]+)l", path.attrib["d"]).groups())  # type: ignore[union-attr]
            sensor = np.array([x, y + 9])
    assert sensor is not None
    return (hits - sensor) * (1, -1)


# Files


@pytest.mark.parametrize("shape", [(1, 1, 3), (7, 5, 3), (48, 64, 4), (3, 200, 4)])
def test_png_files_read_back_equal(shape: tuple[int, ...]) -> None:
    pixels = np.random.default_rng(7).integers(0, 256, shape, np.uint8)
    np.testing.assert_array_equal(np.array(Image.open(io.BytesIO(png(pixels)))), pixels)


# Scans


def scan_of(ranges: list[float]) -> LaserScan:
    return LaserScan(np.array(ranges, np.float32), 0.0, math.tau / len(ranges), 0.02, 12.0)


def test_a_scan_is_drawn_ahead_upwards_and_left_to_the_left() -> None:
    ahead, left, behind, right = points_of(scan_of([4.0, 3.0, 2.0, 1.0]))
    assert ahead == pytest.approx((0.0, 4.0 * ahead[1] / 4), abs=0.1)
    meter = ahead[1] / 4.0
    assert meter > 10.0
    assert left == pytest.approx((-3.0 * meter, 0.0), abs=0.1)
    assert behind == pytest.approx((0.0, -2.0 * meter), abs=0.1)
    assert right == pytest.approx((1.0 * meter, 0.0), abs=0.1)


def test_rings_have_the_size_they_say() -> None:
    scan = scan_of([4.0, 3.0, 2.0, 1.0])
    meter = points_of(scan)[0][1] / 4.0
    drawing = drawing_of(scan)
    radii = [float(ring.attrib["r"]) for ring in drawing.findall(f"{SVG}circle")]
    said = [float(text.text.removesuffix(" m")) for text in drawing.findall(f"{SVG}text")]  # type: ignore[union-attr]
    assert radii == pytest.approx([meter * length for length in said], abs=0.2)
    assert len(radii) >= 2


def test_a_scan_says_what_it_holds() -> None:
    text = text_of(scan_of([0.0, 0.5, 12.0, 2.0, 12.0]))
    assert "5 beams, 2 hits, 1 invalid" in text
    assert "nearest 0.50 m, range 0.02 to 12 m" in text


@pytest.mark.parametrize("ranges", [[0.0] * 8, [12.0] * 8])
def test_a_scan_without_hits_is_drawn_too(ranges: list[float]) -> None:
    scan = scan_of(ranges)
    assert "0 hits" in text_of(scan)
    assert "nothing in range" in text_of(scan)
    assert not len(points_of(scan))


def test_a_sample_tells_its_stamps() -> None:
    sample = threewe.Sample(0, 3, 1.25, scan_of([1.0, 2.0, 3.0]))
    html = sample._repr_html_()  # type: ignore[attr-defined]
    assert "measured at 1.250 s" in html
    assert "3 beams" in html
    imu = threewe.Sample(1, 0, 1.0, threewe.IMUData([0.0] * 3, [0.0] * 3))
    assert imu._repr_html_() is None  # type: ignore[attr-defined]


# Maps


def grid_of() -> OccupancyGrid:
    cells = np.full((40, 60), -1, np.int8)
    cells[30:, :] = 0  # high y
    cells[5:10, 40:50] = 100  # low y, high x
    return OccupancyGrid(cells, 0.1, (-1.0, -0.5))


def test_a_map_is_drawn_the_right_way_up() -> None:
    [(_, pixels)] = images_of(grid_of())
    assert pixels.shape == (40, 60, 4)
    assert pixels[0, 0].tolist() == [255, 255, 255, 255]
    assert pixels[40 - 7, 45].tolist() == [38, 44, 56, 255]
    assert pixels[39, 0].tolist() == [214, 219, 226, 255]


def test_a_map_has_axes_and_a_scale_that_fit_it() -> None:
    grid = grid_of()
    [(image, _)] = images_of(grid)
    meter = float(image.attrib["width"]) / 6.0
    assert float(image.attrib["height"]) == pytest.approx(4.0 * meter, abs=0.2)
    paths = [path.attrib["d"] for path in drawing_of(grid).findall(f"{SVG}path")]
    x, y = re.match(r"M([\d.]+) ([\d.]+)h", paths[0]).groups()  # type: ignore[union-attr]
    assert (float(x), float(y)) == pytest.approx((1.0 * meter, 3.5 * meter), abs=0.2)
    bar = float(re.search(r"m0 -5h([\d.]+)m", paths[2])[1])  # type: ignore[index]
    texts = [text.text for text in drawing_of(grid).findall(f"{SVG}text")]
    assert texts == ["1 m", "free", "unknown", "occupied"]
    assert bar == pytest.approx(1.0 * meter, abs=0.2)
    assert "6.0 x 4.0 m, 60 x 40 cells of 0.1 m, 6.5 m² known" in text_of(grid)


@pytest.mark.parametrize("shape", [(0, 0), (1, 1), (2, 500)])
def test_maps_of_odd_sizes_are_drawn(shape: tuple[int, int]) -> None:
    grid = OccupancyGrid(np.zeros(shape, np.int8))
    pictures = [pixels.shape[:2] for _, pixels in images_of(grid)]
    assert pictures == ([shape] if shape[0] else [])
    assert text_of(grid)


# Images


def test_a_red_object_is_red() -> None:
    bgr = np.zeros((48, 64, 3), np.uint8)
    bgr[10:20, 30:40] = (0, 0, 255)
    [(_, rgb)] = images_of(Picture(bgr))
    assert rgb[15, 35].tolist() == [255, 0, 0]
    np.testing.assert_array_equal(rgb, bgr[..., ::-1])


def test_depth_has_a_scale_and_nothing_where_it_is_invalid() -> None:
    depth = np.tile(np.linspace(1.0, 5.0, 64, dtype=np.float32), (48, 1))
    depth[:10, :10] = 0.0
    (_, pixels), (_, scale) = images_of(Picture(depth))
    np.testing.assert_array_equal(pixels[..., 3] == 0, depth == 0.0)
    brightness = pixels[20, :, :3].sum(axis=1, dtype=int)
    assert (np.diff(brightness) <= 0).all()
    assert pixels[20, 0].tolist() == scale[-1, 0].tolist()
    assert pixels[20, -1].tolist() == scale[0, 0].tolist()
    texts = [text.text for text in drawing_of(Picture(depth)).findall(f"{SVG}text")]
    assert texts == ["5.0 m", "3.0 m", "1.0 m"]


def test_depth_without_a_valid_pixel_is_drawn() -> None:
    (_, pixels), _ = images_of(Picture(np.zeros((4, 4), np.float32)))
    assert not pixels[..., 3].any()


@pytest.mark.parametrize(
    "array", [np.zeros((4, 4)), np.zeros((4, 4, 3)), np.zeros((4, 4, 4), np.uint8), np.zeros((0, 4, 3), np.uint8)]
)
def test_what_is_no_image_is_refused(array: NDArray[np.generic]) -> None:
    with pytest.raises(threewe.ContractError, match=r"an image is \(H, W, 3\) uint8 BGR or \(H, W\) float32"):
        threewe.show(array)


async def test_colour_and_depth_are_shown_side_by_side() -> None:
    async with Robot(hardware="3we_depth_v2", noise="ideal") as robot:
        image = robot.get_rgbd_image()
    (left, color), (right, depth), (_, scale) = images_of(image)
    np.testing.assert_array_equal(color, image.color[..., ::-1])
    assert image.depth is not None
    np.testing.assert_array_equal(depth[..., 3] == 0, image.depth == 0.0)
    nearest = np.unravel_index(np.where(image.depth > 0.0, image.depth, np.inf).argmin(), image.depth.shape)
    assert depth[nearest].tolist() == scale[-1, 0].tolist()
    assert float(right.attrib["x"]) > float(left.attrib["width"])
    assert left.attrib["width"] == right.attrib["width"]
    assert "640 x 480" in text_of(image)


async def test_an_image_without_depth_is_shown_alone() -> None:
    images: list[threewe.RGBDImage] = []
    async with Robot(scene="corridor_v1") as robot:
        robot.observe(lambda tick: images.extend(s.data for s in tick.samples if isinstance(s.data, threewe.RGBDImage)))
        await robot.sleep(0.5)
    [(_, color)] = images_of(images[0])
    np.testing.assert_array_equal(color, images[0].color[..., ::-1])


def test_show_prints_where_there_is_no_notebook(capsys: pytest.CaptureFixture[str]) -> None:
    threewe.show(np.zeros((48, 64, 3), np.uint8), grid_of())
    assert capsys.readouterr().out.splitlines() == ["Picture(64 x 48, colour)", repr(grid_of())]


def test_show_displays_in_a_notebook(monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[object] = []
    for name, contents in (("IPython", {"get_ipython": object}), ("IPython.display", {"display": shown.append})):
        module = types.ModuleType(name)
        vars(module).update(contents)
        monkeypatch.setitem(sys.modules, name, module)
    grid = grid_of()
    threewe.show(np.zeros((4, 4, 3), np.uint8), grid)
    assert isinstance(shown[0], Picture)
    assert shown[1] is grid
