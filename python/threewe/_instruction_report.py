"""HTML page of an instruction that was executed: map, way, things, what each step rests on, and what a model was asked
and answered. Nothing is fetched.
"""

from __future__ import annotations

import base64
import html
import io
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from threewe import drawing as d
from threewe._core import MappedThing, color_names
from threewe._execution_result import Exchange, ExecutedStep, ExecutionResult
from threewe._sight import as_jpeg
from threewe._web import web_file
from threewe.errors import ConfigError, ContractError

WIDTH, HEIGHT = 1200, 800  # [px] of the map
MARGIN = 0.6  # [m] around what is known
SHOWN = 0.5  # least probability of a thing's kind to be named
PLACE = (52, 116, 219, 255)
START = (46, 160, 92, 255)


def write_report(result: ExecutionResult, path: Path) -> None:
    """See `ExecutionResult.save`."""
    check_page(path)
    try:
        path.write_text(report(result), encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written: {error.strerror}") from None


def check_page(path: Path) -> None:
    """Raises ContractError unless a page may be written under that name."""
    if path.suffix != ".html":
        raise ContractError(f"path: {path} must end in .html")


def report(result: ExecutionResult) -> str:
    """The page."""
    text = html.escape
    steps = "".join(_step(step) for step in result.steps)
    said = result.answer or result.detail
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{text(result.instruction)}</title><style>{web_file("report.css")}</style></head><body>
<h1>{text(result.instruction) or "(no words)"}</h1>
<ul class="badges"><li><b>{text(result.reason)}</b></li>
<li>{"seen by its own detector" if result.verified else "not verified by its own detector"}</li></ul>
<p class="said">{text(said)}</p>
<dl class="cards">
<div><dt>driven</dt><dd>{result.distance:.1f} m</dd></div>
<div><dt>robot time</dt><dd>{result.duration:.0f} s</dd></div>
<div><dt>steps</dt><dd>{len(result.steps)}</dd></div>
<div><dt>things on its map</dt><dd>{len(result.things)}</dd></div>{_thinking(result)}
</dl>
<h2>Its own map, its way, and what it knows of</h2>
<img class="map" alt="the robot's map from above" src="{_data(_map(result), "png")}">
<ul class="legend"><li><i class="dot" style="border-color:#2ea05c"></i>start</li>
<li><i style="border-color:#3474db"></i>way</li>
<li><i class="dot" style="border-color:#e23e78"></i>what it was about</li></ul>
<h2>Steps</h2>
<ol class="steps">{steps}</ol>{_conversation(result)}
</body></html>
"""


def _thinking(result: ExecutionResult) -> str:
    """What a model took, where one was asked."""
    if not result.tokens:
        return ""
    return f"""
<div><dt>thinking</dt><dd>{result.thinking:.0f} s</dd></div>
<div><dt>tokens</dt><dd>{result.tokens}</dd></div>"""


def _step(step: ExecutedStep) -> str:
    good = "good" if step.reason == "done" else "bad"
    detail = f"<br><small>{html.escape(step.detail)}</small>" if step.detail else ""
    picture = ""
    if step.picture.size:
        picture = ""
    if step.picture.size:
        picture = f'<img alt="the camera\'s picture at the end of this step" src="{_picture(step)}">'
    return f"""<li><figure>{picture}
<figcaption><code>{html.escape(step.text)}</code><br><span class="{good}">{html.escape(step.reason)}</span>
<small>{step.begun:.1f} to {step.ended:.1f} s</small>{detail}</figcaption></figure></li>
"""


def _conversation(result: ExecutionResult) -> str:
    """What was said to and by a model, each picture where it was sent first; empty without a model."""
    sent: set[bytes] = set()
    said = []
    for exchange in result.conversation:
        new = [picture for picture in exchange.pictures if picture not in sent]
        sent.update(new)
        said.append(_exchange(exchange, new))
    return f'\n<h2>Conversation with the model</h2>\n<ol class="talk">{"".join(said)}</ol>' if said else ""


def _exchange(exchange: Exchange, new: list[bytes]) -> str:
    text = html.escape
    again = len(exchange.pictures) - len(new)
    shown = "".join(f'<img alt="a picture that was sent" src="{_image(picture)}">' for picture in new)
    before = f"<small>and {again} that it had been sent before</small>" if again else ""
    pictures = f'<div class="sent">{shown}{before}</div>' if exchange.pictures else ""
    return f"""<li><small>{exchange.time:.1f} s, answered in {exchange.seconds:.1f} s, {exchange.tokens} tokens</small>
<details><summary>question</summary><pre>{text(exchange.question)}</pre></details>{pictures}
<pre class="{"bad" if exchange.failed else "answer"}">{text(exchange.answer) or "(nothing)"}</pre></li>
"""


def _picture(step: ExecutedStep) -> str:
    """The camera's picture with the detector's boxes, as a data URI."""
    picture = Image.fromarray(np.ascontiguousarray(step.picture[..., ::-1]))
    draw = ImageDraw.Draw(picture)
    font = d.text_font(picture.width / 40)
    for kind, said, box in reversed(step.seen):  # the largest last
        color = d.furniture_color(kind)
        draw.rectangle(box, outline=color, width=max(2, picture.width // 240))
        corner = (box[0] + 4, max(0, box[1] - font.getbbox(said)[3] - 4))
        draw.rectangle(draw.textbbox(corner, said, font), fill=color)
        draw.text(corner, said, d.INK if sum(color[:3]) > 380 else (255, 255, 255, 255), font)
    return _data(picture, "jpeg")


def _map(result: ExecutionResult) -> Image.Image:
    grid = result.map
    points = [(pose.x, pose.y) for pose in result.way] + [corner for place in result.places for corner in place.polygon]
    rows, columns = np.nonzero(grid.data >= 0)
    if len(rows):
        x, y = (grid.origin[k] + grid.resolution * cells for k, cells in ((0, columns), (1, rows)))
        points += [(float(x.min()), float(y.min())), (float(x.max()), float(y.max()))]
    view = _view(points)
    picture = d.draw_map(grid, view)
    for place in result.places:
        _draw_place(picture, view, [(x, y) for x, y in place.polygon], place.name)
    d.draw_path(picture, view, [(pose.x, pose.y) for pose in result.way], d.TRAJECTORY)
    begun = result.way[0]
    d.draw_goal(picture, view, (begun.x, begun.y), 0.14, START)
    meant = {step.thing for step in result.steps}
    for thing in result.things:
        _draw_thing(picture, view, thing, result.labels, thing.id in meant)
    end = result.way[-1]
    _draw_arrow(picture, view, end.x, end.y, end.theta)
    return d.finish(picture)


def _view(points: list[tuple[float, float]]) -> d.View:
    """All of them, in the page's shape."""
    x, y = ([point[k] for point in points] for k in (0, 1))
    height = max(max(y) - min(y) + 2 * MARGIN, (max(x) - min(x) + 2 * MARGIN) * HEIGHT / WIDTH)
    width = height * WIDTH / HEIGHT
    middle = ((min(x) + max(x)) / 2, (min(y) + max(y)) / 2)
    low = (middle[0] - width / 2, middle[1] - height / 2)
    return d.View(low, (low[0] + width, low[1] + height), WIDTH / width)


def _draw_thing(picture: Image.Image, view: d.View, thing: MappedThing, labels: tuple[str, ...], meant: bool) -> None:
    probability = max(thing.kinds)
    kind = labels[thing.kind_index] if probability >= SHOWN else "thing"
    if kind == "thing" and not meant:
        return
    draw = ImageDraw.Draw(picture)
    x, y = view.point(*thing.position)
    r = 0.11 * view.pixels
    draw.ellipse([x - r, y - r, x + r, y + r], d.furniture_color(kind), d.INK, 2)
    if meant:
        d.draw_goal(picture, view, (thing.position[0], thing.position[1]), 0.35)
    font = d.text_font(max(26.0, 0.2 * view.pixels))
    said = f"{thing.color} {kind}" if thing.color in color_names() else kind
    draw.text((x, y - 1.4 * r), said, d.INK, font, anchor="mb", stroke_width=3, stroke_fill=(255, 255, 255, 255))


def _draw_place(picture: Image.Image, view: d.View, corners: list[tuple[float, float]], name: str) -> None:
    draw = ImageDraw.Draw(picture)
    if len(corners) > 1:
        d.draw_path(picture, view, [*corners, corners[0]], PLACE, 0.04)
    middle = (sum(x for x, _ in corners) / len(corners), sum(y for _, y in corners) / len(corners))
    font = d.text_font(max(30.0, 0.28 * view.pixels))
    draw.text(view.point(*middle), name, PLACE, font, anchor="mm", stroke_width=3, stroke_fill=(255, 255, 255, 255))


def _draw_arrow(picture: Image.Image, view: d.View, x: float, y: float, theta: float) -> None:
    """Where the robot stands at the end, and which way it looks."""
    c, s = np.cos(theta), np.sin(theta)
    corners = [(0.22, 0.0), (-0.14, 0.14), (-0.06, 0.0), (-0.14, -0.14)]
    outline = view.points([(x + c * a - s * b, y + s * a + c * b) for a, b in corners])
    ImageDraw.Draw(picture).polygon(outline, d.BODY, d.INK, 2)


def _data(picture: Image.Image, form: str) -> str:
    if form == "jpeg":
        content = as_jpeg(picture)
    else:
        file = io.BytesIO()
        picture.save(file, form)
        content = file.getvalue()
    return _image(content)


def _image(content: bytes) -> str:
    """A JPEG or PNG as a data URI."""
    form = "png" if content.startswith(b"\x89PNG") else "jpeg"
    return f"data:image/{form};base64,{base64.b64encode(content).decode()}"
