"""Detectors of one's own: an ONNX graph that finds boxes, with its labels and layout in a YAML file beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe._core import BoxLayout, Detector
from threewe._extras import needed_for
from threewe.errors import ConfigError
from threewe.language import read_command

Rows = NDArray[np.float32]


def load_detector(name: str) -> Detector:
    """The detector that ships by its name, a file that ends in .safetensors, or a graph that ends in .onnx.

    Raises ConfigError with the file and what is wrong.
    """
    path = Path(name)
    if path.suffix != ".onnx":
        return Detector.load(name)
    if not path.is_file():
        raise ConfigError(f"detector: {path}: no such file")
    beside = path.with_suffix(".yaml")
    if not beside.is_file():
        raise ConfigError(f"detector: {path} needs its labels and layout next to it, in {beside.name}")
    layout = BoxLayout.load(str(beside))
    for label in filter(None, layout.labels):
        _require_kind(beside, label)
    return Detector.of_boxes(layout, _Graph(path, layout))


def _require_kind(file: Path, label: str) -> None:
    """A label is a kind of things that sentences can name."""
    steps = read_command(f"find the {label}").steps
    if len(steps) == 1 and steps[0].thing.kind == label:
        return
    known = steps[0].thing.kind if len(steps) == 1 else ""
    meant = f": it is called '{known}'" if known else ", such as chair; or '-' for one that is not used"
    raise ConfigError(f"{file}: labels: '{label}' is no kind that instructions know{meant}")


class _Graph:
    """The network: a picture in, boxes in its pixels out."""

    def __init__(self, path: Path, layout: BoxLayout) -> None:
        with needed_for("detectors in .onnx files", "policy"):
            import onnxruntime
        self._path, self._layout = path, layout
        settings = onnxruntime.SessionOptions()
        settings.intra_op_num_threads = 1
        settings.log_severity_level = 3
        try:
            self._session = onnxruntime.InferenceSession(str(path), settings, providers=["CPUExecutionProvider"])
        except Exception as error:  # its errors have no class of their own
            raise ConfigError(f"detector: {path}: no ONNX graph: {_line(error)}") from None
        self._numbers = 4 + len(layout.labels)
        self._read_input()
        self._check_output(self._run(np.zeros((*self._size, 3), np.uint8)))  # which sizes alone do not tell

    def _read_input(self) -> None:
        inputs = self._session.get_inputs()
        shape: Any = inputs[0].shape if len(inputs) == 1 else []
        if len(shape) != 4 or 3 not in (shape[1], shape[3]) or inputs[0].type not in TYPES:
            said = ", ".join(f"{one.name} {one.shape} {one.type}" for one in inputs)
            raise ConfigError(
                f"detector: {self._path}: its input must be one picture, float or uint8 (1, 3, H, W) or "
                f"(1, H, W, 3), got {said}"
            )
        self._name, self._type = inputs[0].name, TYPES[inputs[0].type]
        self._channels_first = shape[1] == 3
        height, width = shape[2:] if self._channels_first else shape[1:3]
        if not all(isinstance(size, int) and 16 <= size <= 4096 for size in (height, width)):
            raise ConfigError(
                f"detector: {self._path}: its input must have a fixed height and width of 16 to 4096 "
                f"pixels, got {shape}"
            )
        self._size = height, width

    def _check_output(self, output: Any) -> None:
        shape: Any = getattr(output, "shape", ())
        if len(shape) != 3 or shape[0] != 1 or self._numbers not in shape[1:]:
            raise ConfigError(
                f"detector: {self._path}: its first output must be (1, N, {self._numbers}) or (1, {self._numbers}, N): "
                f"a box and a score for each of the {len(self._layout.labels)} labels, got {tuple(shape)}"
            )

    def _run(self, picture: NDArray[np.uint8]) -> Any:
        """The first output for a picture of the input's size."""
        layout = self._layout
        pixels: Any = picture[..., ::-1] if layout.rgb else picture
        if self._type is np.float32:
            mean, deviation = np.array(layout.mean, np.float32), np.array(layout.deviation, np.float32)
            pixels = (pixels / np.float32(layout.scale) - mean) / deviation
        if self._channels_first:
            pixels = pixels.transpose(2, 0, 1)
        try:
            return self._session.run(None, {self._name: np.ascontiguousarray(pixels[None], self._type)})[0]
        except Exception as error:
            raise ConfigError(f"detector: {self._path}: it cannot be run: {_line(error)}") from None

    def __call__(self, picture: NDArray[np.uint8]) -> Rows:
        height, width = picture.shape[:2]
        rows, columns = (
            (np.arange(to) * of + of // 2) // to for to, of in zip(self._size, (height, width), strict=True)
        )
        found = np.asarray(self._run(picture[rows[:, None], columns]), np.float32)[0]
        if found.shape[1] != self._numbers:
            found = found.T
        scale = np.ones(self._numbers, np.float32)
        scale[:4] = [width / self._size[1], height / self._size[0]] * 2
        return np.ascontiguousarray(found * scale)


TYPES: dict[str, Any] = {"tensor(float)": np.float32, "tensor(uint8)": np.uint8}


def _line(error: Exception) -> str:
    return " ".join(str(error).split())[:200]
