"""What computes a policy's actions: here, by onnxruntime from its graph."""

from __future__ import annotations

import os
from importlib.util import find_spec
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from threewe._core import GraphSession, Inference
from threewe._extras import needed_for
from threewe.ai.folder import CameraInput, Policy, image_input
from threewe.errors import ConfigError, ThreeweError

LIBRARY = "THREEWE_ONNXRUNTIME"
"""Environment variable that names onnxruntime's library elsewhere than in its wheel."""


class Engine(Protocol):
    """Computes the actions of one observation; called from several threads at a time."""

    def infer(self, feed: dict[str, NDArray[np.float32]], instruction: str) -> NDArray[np.float32]:
        """(1, chunk, numbers) from the policy's inputs by name, pictures (1, 3, H, W) 0 to 1, and the text."""


class GraphEngine:
    """Runs an ONNX graph on one thread, in C++."""

    def __init__(self, policy: Policy, graph: bytes) -> None:
        """The graph as bytes: what has no folder can name no other file. Raises ConfigError with the graph's path."""
        library, inputs = str(onnxruntime_library()), policy.graph_inputs()
        ((output, lengths),) = policy.outputs().items()
        self._inputs = list(inputs)
        shapes = [(name, list(shape)) for name, shape in inputs.items()]
        try:
            self._session = GraphSession(library, graph, shapes, (output, list(lengths)))
        except ThreeweError as error:
            raise ConfigError(f"{policy.graph}: onnxruntime does not take it: {error}") from None

    def infer(self, feed: dict[str, NDArray[np.float32]], instruction: str) -> NDArray[np.float32]:  # noqa: ARG002
        """See `Engine`; a graph reads no text."""
        actions: NDArray[np.float32] = self._session.run([feed[name] for name in self._inputs])
        return actions

    def start(
        self, pictures: list[tuple[CameraInput, NDArray[np.uint8]]], others: dict[str, NDArray[np.float32]]
    ) -> Inference:
        """The same in a thread that needs no Python, from pictures as cameras give them, (H, W, 3) BGR."""
        given: dict[str, object] = {**others}
        for camera, image in pictures:
            given[image_input(camera.name)] = (image, camera.height, camera.width, camera.color == "rgb")
        return self._session.start([given[name] for name in self._inputs])


def onnxruntime_library() -> Path:
    """The library in onnxruntime's wheel, whose C interface is used. Raises ConfigError."""
    if (named := os.environ.get(LIBRARY)) is not None:
        return Path(named)
    with needed_for("running a policy", "policy"):
        found = find_spec("onnxruntime")
        if found is None or found.origin is None:
            raise ImportError("No module named 'onnxruntime'")
        files = sorted(Path(found.origin).with_name("capi").glob("libonnxruntime.so.*"))
        if not files:
            raise ImportError("onnxruntime has no libonnxruntime.so")
    return files[-1]
