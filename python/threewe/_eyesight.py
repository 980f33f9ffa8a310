"""Eyesight test of vision models: three digits on a colored ground, drawn here, to be read from the picture."""

from __future__ import annotations

import io
import re

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from threewe import drawing as d

QUESTION = "Which three digits does the picture show, and on what color? Answer with the digits and the color alone."
GROUNDS = {"red": (214, 40, 40), "green": (30, 140, 60), "blue": (40, 80, 210), "yellow": (240, 205, 40)}
SIZE = (512, 288)  # [px]
CELL = 150  # [px] from digit to digit


def test_picture(digits: str, ground: str) -> bytes:
    """The picture, PNG."""
    picture = Image.new("RGB", SIZE, GROUNDS[ground])
    font = d.text_font(170)
    draw = ImageDraw.Draw(picture)
    for i, digit in enumerate(digits):
        draw.text((106 + CELL * i, SIZE[1] / 2), digit, (255, 255, 255), font, anchor="mm")
    file = io.BytesIO()
    picture.save(file, "png")
    return file.getvalue()


def passes(answer: str, digits: str, ground: str) -> bool:
    """Whether an answer has the digits, in order and no others, and the color and no other."""
    said = "".join(re.findall(r"\d", answer))
    return said == digits and [name for name in GROUNDS if name in answer.lower()] == [ground]


def read_picture(content: bytes) -> str:
    """What such a picture shows, by comparing its pixels: "472 red". Empty where it is another picture."""
    pixels = _pixels(content)
    if pixels.shape != (SIZE[1], SIZE[0], 3):
        return ""
    ground = min(GROUNDS, key=lambda name: np.abs(pixels[0, 0] - np.array(GROUNDS[name])).sum())
    drawn = [_pixels(test_picture(3 * str(n), ground)) for n in range(10)]
    parts = [np.s_[:, 31 + CELL * i : 31 + CELL * (i + 1)] for i in range(3)]
    errors = [[np.abs(one[part] - pixels[part]).sum() for one in drawn] for part in parts]
    return f"{''.join(str(np.argmin(of)) for of in errors)} {ground}"


def _pixels(content: bytes) -> NDArray[np.int64]:
    return np.asarray(Image.open(io.BytesIO(content)).convert("RGB"), np.int64)
