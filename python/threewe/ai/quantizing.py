"""Policies in eight bits: weights and activations of convolutions and linear layers, by onnxruntime."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from threewe._extras import needed_for
from threewe.ai.calibration import Feed
from threewe.ai.folder import GRAPH, Policy, write_policy
from threewe.errors import ConfigError

LAYERS = ["Conv", "Gemm"]
"""Operators that are computed in eight bits; what is between them stays float32."""


def write_int8(policy: Policy, feeds: Sequence[Feed], output: Path) -> None:
    """Writes the same policy in eight bits, its ranges chosen by observations. Raises ConfigError."""
    if output.exists():
        raise ConfigError(f"output: {output} exists already")
    path = list(sys.path)
    with needed_for("making a policy int8", "policy"):
        import onnx
        from onnxruntime.quantization import CalibrationDataReader, QuantFormat, QuantType, quantize_static
    sys.path[:] = path  # onnxruntime adds a folder with a `benchmark.py`, which would stand in for the user's own

    if any(node.op_type == "QuantizeLinear" for node in onnx.load(str(policy.folder / GRAPH)).graph.node):
        raise ConfigError(f"{policy.folder / GRAPH}: has eight bits already")

    class Reader(CalibrationDataReader):  # type: ignore[misc]
        left: Iterator[Any] = iter(feeds)

        def get_next(self) -> Feed | None:
            return next(self.left, None)

    with TemporaryDirectory() as folder:
        graph = Path(folder, GRAPH)
        logging.disable(logging.WARNING)  # it advises to optimise graphs before, of which nothing is left to be
        try:
            quantize_static(
                str(policy.folder / GRAPH),
                str(graph),
                Reader(),
                quant_format=QuantFormat.QDQ,
                op_types_to_quantize=LAYERS,
                per_channel=True,
                reduce_range=True,  # seven bits: older processors' sums of eight overflow
                activation_type=QuantType.QUInt8,
                weight_type=QuantType.QInt8,
            )
        finally:
            logging.disable(logging.NOTSET)
        made = {**policy.training, "int8": f"ranges by {len(feeds)} observations"}
        write_policy(replace(policy, folder=output, training=made), graph.read_bytes())
