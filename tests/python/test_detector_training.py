"""Training of the object detector: the pictures that it learns from, and learning on from a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file
from threewe import ConfigError, asset_directories
from threewe._device import torch_device
from threewe.detector.pictures import LABELS, UNSURE, labelled_pictures
from threewe.detector.training import Pictures, some_pixels
from threewe.detector.weights import load_network, save_detector

[SHIPPED] = [
    path for folder in asset_directories() if (path := Path(folder, "detectors/indoor_v1.safetensors")).exists()
]


@pytest.fixture(scope="module")
def pictures() -> Pictures:
    return Pictures.of(list(labelled_pictures(3, 2)))


def test_pictures_repeat_and_show_many_kinds(pictures: Pictures) -> None:
    again = Pictures.of(list(labelled_pictures(3, 2, workers=2)))
    np.testing.assert_array_equal(again.pictures, pictures.pictures)
    np.testing.assert_array_equal(again.kinds, pictures.kinds)
    shown = set(np.unique(pictures.kinds)) - {0, UNSURE}
    assert len(shown) >= 5
    assert max(shown) < len(LABELS)


def test_a_network_that_is_read_back_is_the_one_that_was_written(tmp_path: Path, pictures: Pictures) -> None:
    pixels = some_pixels(pictures)
    network = load_network(SHIPPED, pixels)
    again = tmp_path / "again.safetensors"
    save_detector(network, again, "the same")
    before, after = load_file(SHIPPED), load_file(again)
    for name in (name for name in before if name.endswith("weight")):
        assert np.abs(before[name].astype(int) - after[name]).max() <= 1, name  # of 4095
    evaluated = network(pixels[:8])
    network.train()  # by the statistics of what it is given
    kinds = network(pixels)[:8, : len(LABELS)].argmax(1)
    assert (kinds == evaluated[:, : len(LABELS)].argmax(1)).float().mean() > 0.97


def test_a_file_of_another_network_is_one_error(tmp_path: Path, pictures: Pictures) -> None:
    other = tmp_path / "other.safetensors"
    save_file({"stem.weight": np.zeros((32, 3, 3, 12), np.int16)}, other)
    with pytest.raises(ConfigError, match=r"other\.safetensors: it holds no network like the one that is trained"):
        load_network(other, some_pixels(pictures))
    with pytest.raises(ConfigError, match=r"nothing\.safetensors"):
        load_network(tmp_path / "nothing.safetensors", some_pixels(pictures))


@pytest.mark.parametrize("device", ["cuda:99", "nothing"])
def test_a_device_that_is_not_there_is_one_error(device: str) -> None:
    with pytest.raises(ConfigError, match=f"device: '{device}' cannot be used here: .*; cpu always can"):
        torch_device(device)
