"""The detector in integer arithmetic: what the C++ class `Detector` reads.

A safetensors file. Features are 8.8 fixed-point numbers; the weights of output channel c have `shift[c]` binary places,
its bias 8 more. The metadata hold `layers` (what follows what, see `LAYERS`), `labels`, `radii` (see `radii`) and
`description`.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from threewe.detector.network import Layer, Network
from threewe.detector.pictures import LABELS, radii
from threewe.errors import ConfigError

LARGEST = 4095  # of a weight, so that sums stay within 32 bits
LARGEST_SUM = 500_000  # of the weights of one channel
MOST_PLACES = 15

LAYERS: list[dict[str, Any]] = [
    {"name": "stem", "input": "pixels"},
    {"name": "down_8", "input": "stem"},
    {"name": "a_8", "input": "down_8"},
    {"name": "b_8", "input": "a_8", "add": "down_8"},
    {"name": "down_16", "input": "b_8"},
    {"name": "a_16", "input": "down_16"},
    {"name": "b_16", "input": "a_16", "add": "down_16"},
    {"name": "down_32", "input": "b_16"},
    {"name": "a_32", "input": "down_32"},
    {"name": "b_32", "input": "a_32", "add": "down_32"},
    {"name": "up_16", "input": "b_32"},
    {"name": "merge_16", "kind": "merge", "input": "up_16", "add": "b_16"},
    {"name": "c_16", "input": "merge_16"},
    {"name": "up_8", "input": "c_16"},
    {"name": "merge_8", "kind": "merge", "input": "up_8", "add": "b_8"},
    {"name": "c_8", "input": "merge_8"},
    {"name": "d_8", "input": "c_8"},
    {"name": "head", "kind": "head", "input": "d_8"},
]
"""The order of `Network.forward`."""


def save_detector(network: Network, path: str | os.PathLike[str], description: str) -> None:
    """Writes a trained network in integers."""
    from safetensors.numpy import save_file

    arrays: dict[str, NDArray[Any]] = {}
    layers = []
    for entry in LAYERS:
        layer = getattr(network, entry["name"], None)
        if layer is None:  # a merge has no weights
            layers.append(entry)
            continue
        weights, bias = _folded(layer)
        if entry["input"] == "pixels":
            weights = weights * (256 / 255)  # a pixel of 255 is 1
        arrays |= {f"{entry['name']}.{key}": value for key, value in _integers(weights, bias).items()}
        convolution = layer.convolution if isinstance(layer, Layer) else layer
        shape = {"outputs": weights.shape[0], "size": weights.shape[1], "stride": convolution.stride[0]}
        layers.append({"kind": "convolution", **entry, **shape})
    metadata = {
        "layers": json.dumps(layers),
        "labels": json.dumps(list(LABELS)),
        "radii": json.dumps(radii()),
        "description": description,
    }
    save_file(arrays, os.fspath(path), metadata)


def load_network(path: str | os.PathLike[str], pixels: Tensor) -> Network:
    """The network of a file, to be trained further. Its normalization is that of (N, 12, H/2, W/2) pixels.

    Raises ConfigError for a file of another network.
    """
    from safetensors import SafetensorError
    from safetensors.numpy import load_file

    if not Path(path).is_file():
        raise ConfigError(f"{os.fspath(path)}: there is no such file")
    try:
        arrays = load_file(path)
    except SafetensorError as error:
        raise ConfigError(f"{os.fspath(path)}: it is no safetensors file: {error}") from None
    network = Network().eval()
    try:
        for entry in LAYERS:
            layer = getattr(network, entry["name"], None)
            if layer is not None:
                weights, bias = (tensor.float() for tensor in _floats(arrays, entry))
                convolution = layer.convolution if isinstance(layer, Layer) else layer
                with torch.no_grad():
                    convolution.weight.copy_(weights)
                    (layer.normalization if isinstance(layer, Layer) else layer).bias.copy_(bias)
    except (KeyError, RuntimeError) as error:
        raise ConfigError(f"{os.fspath(path)}: it holds no network like the one that is trained: {error}") from None
    hooks = [layer.register_forward_hook(_normalize) for layer in network.modules() if isinstance(layer, Layer)]
    with torch.no_grad():
        network(pixels)
    for hook in hooks:
        hook.remove()
    return network


def _floats(arrays: dict[str, NDArray[Any]], entry: dict[str, Any]) -> tuple[Tensor, Tensor]:
    """Weights (outputs, inputs, size, size) and bias of a layer."""
    weights, bias, shift = (arrays[f"{entry['name']}.{key}"].astype(np.float64) for key in ("weight", "bias", "shift"))
    weights = (weights / 2.0 ** shift[:, None, None, None]).transpose(0, 3, 1, 2)
    if entry["input"] == "pixels":
        weights = weights * (255 / 256)
    return torch.from_numpy(weights), torch.from_numpy(bias / 2.0 ** (8 + shift))


def _normalize(layer: Layer, inputs: tuple[Tensor, ...], _: Tensor) -> None:
    """Gives a layer the statistics of its inputs, and leaves what it computes of them as it is."""
    sums = layer.convolution(inputs[0])
    norm = layer.normalization
    mean, variance = sums.mean((0, 2, 3)), sums.var((0, 2, 3))
    assert norm.running_mean is not None
    assert norm.running_var is not None
    norm.running_mean.copy_(mean)
    norm.running_var.copy_(variance)
    norm.weight.copy_((variance + norm.eps).sqrt())
    norm.bias.add_(mean)


def _folded(layer: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(outputs, size, size, inputs) weights and the bias, normalization included."""
    if not isinstance(layer, Layer):
        weights, bias = (parameter.detach().numpy().astype(np.float64) for parameter in (layer.weight, layer.bias))
        return weights.transpose(0, 2, 3, 1), bias
    weights = layer.convolution.weight.detach().numpy().astype(np.float64).transpose(0, 2, 3, 1)
    norm = layer.normalization
    gamma, beta, mean, variance = (
        tensor.detach().numpy().astype(np.float64)
        for tensor in (norm.weight, norm.bias, norm.running_mean, norm.running_var)
    )
    scale = gamma / np.sqrt(variance + norm.eps)
    return weights * scale[:, None, None, None], beta - mean * scale


def _integers(weights: NDArray[np.float64], bias: NDArray[np.float64]) -> dict[str, NDArray[Any]]:
    """Each channel with as many binary places as its largest weight and their sum allow."""
    flat = np.abs(weights.reshape(len(weights), -1))
    room = np.minimum(LARGEST / (flat.max(1) + 1e-9), LARGEST_SUM / (flat.sum(1) + 1e-9))
    shift = np.clip(np.floor(np.log2(room)), 1, MOST_PLACES).astype(np.int32)
    return {
        "weight": np.ascontiguousarray(np.round(weights * 2.0 ** shift[:, None, None, None]), np.int16),
        "bias": np.round(bias * 2.0 ** (8 + shift)).astype(np.int32),
        "shift": shift,
    }
