"""What a played Hailo computes, and the compiler that makes its files. `hailort.c` is the library."""

from __future__ import annotations

import ast
import json
import subprocess
import sysconfig
from pathlib import Path

import numpy as np
import onnxruntime

MAGIC = b"\x01HEF"


def build(folder: Path) -> Path:
    """Compiles the library."""
    library = folder / "libhailort.so"
    include = sysconfig.get_path("include")
    source = Path(__file__).with_name("hailort.c")
    subprocess.run(
        ["cc", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", f"-I{include}", source, "-o", library], check=True
    )
    return library


def compile_encoder(folder: Path) -> None:
    """Does what `compile.sh` would: makes policy/encoder.hef of the encoder's graph and its script."""
    (line,) = (folder / "encoder.alls").read_text().splitlines()
    assert line.startswith("normalization1 = normalization(")
    mean, std = ast.literal_eval(line.removeprefix("normalization1 = normalization"))
    head = json.dumps({"mean": mean, "std": std}).encode()
    (folder / "policy" / "encoder.hef").write_bytes(MAGIC + head + b"\n" + (folder / "encoder.onnx").read_bytes())


class Encoder:
    """A `.hef` at work."""

    def __init__(self, file: str) -> None:
        head, _, graph = Path(file).read_bytes().removeprefix(MAGIC).partition(b"\n")
        self.about = json.loads(head)
        self.session = onnxruntime.InferenceSession(graph, providers=["CPUExecutionProvider"])
        _, _, self.height, self.width = self.session.get_inputs()[0].shape

    def picture_bytes(self) -> int:
        return self.height * self.width * 3

    def feature_bytes(self) -> int:
        return 4 * int(np.prod(self.session.get_outputs()[0].shape))

    def features(self, picture: bytes) -> bytes:
        """Float32 (h, w, C) of bytes (H, W, 3)."""
        pixels = np.frombuffer(picture, np.uint8).reshape(1, self.height, self.width, 3).astype(np.float32)
        scaled = (pixels - np.array(self.about["mean"])) / np.array(self.about["std"])
        (found,) = self.session.run(None, {"picture": scaled.transpose(0, 3, 1, 2).astype(np.float32)})
        return np.ascontiguousarray(found[0].transpose(1, 2, 0)).tobytes()
