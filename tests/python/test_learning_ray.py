"""The PPO example samples on a Ray cluster what it samples in one process, to the bit."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from types import ModuleType
from typing import Any

import pytest

from verify.learning import EXAMPLE, example

if importlib.util.find_spec("ray") is None:
    pytest.skip("Ray is not installed", allow_module_level=True)

import ray
import torch
from ray.cluster_utils import Cluster
from threewe.benchmark.ray_engine import cluster

pytestmark = pytest.mark.filterwarnings("ignore")  # warnings of Ray itself


@pytest.fixture(scope="module")
def ppo() -> ModuleType:
    module = example()
    ray.cloudpickle.register_pickle_by_value(module)  # it is no module that workers could import
    return module


@pytest.fixture(scope="module")
def address(only_cluster: None) -> Iterator[str]:
    """The cluster of all tests here."""
    del only_cluster
    made = Cluster(initialize_head=True, head_node_args={"num_cpus": 2})
    made.add_node(num_cpus=2)
    yield made.address
    ray.shutdown()
    made.shutdown()


def small(ppo: ModuleType, workers: int) -> Any:
    return ppo.Settings(seed=3, lessons=(("realistic", 2, 2), ("ideal", 1, 1)), num_envs=12, rollout=8, workers=workers)


@pytest.mark.parametrize("workers", [1, 3])
def test_samples_are_the_same_as_in_one_process(ppo: ModuleType, address: str, workers: int) -> None:
    settings = small(ppo, workers)
    torch.set_num_threads(1)
    torch.manual_seed(1)
    policy, critic = ppo.Policy(), ppo.network(ppo.FEATURES + 1, 1)
    with cluster(address) as connected:
        local, remote = ppo.Local(settings, 0), ppo.Remote(connected, settings, 0)
        for _ in range(3):
            (here, won_here), (there, won_there) = (one.sample(policy, critic) for one in (local, remote))
            assert here.seen.shape == (8, 12, ppo.FEATURES)
            assert here.values.shape == (9, 12)
            assert won_here == won_there
            for column, other in zip(here, there, strict=True):
                assert torch.equal(column, other)
            with torch.no_grad():
                for weights in (*policy.parameters(), *critic.parameters()):
                    weights += 0.05 * torch.randn_like(weights)


def test_workers_draw_for_themselves(ppo: ModuleType) -> None:
    torch.manual_seed(1)
    policy, critic = ppo.Policy(), ppo.network(ppo.FEATURES + 1, 1)
    rollout, _ = ppo.Local(small(ppo, 3), 0).sample(policy, critic)
    again, _ = ppo.Local(small(ppo, 3), 0).sample(policy, critic)
    assert torch.equal(rollout.choices, again.choices)
    shares = rollout.seen[0].chunk(3)
    assert not torch.equal(shares[0], shares[1])
    with pytest.raises(ValueError, match="12 environments are no whole number for each of 5 workers"):
        ppo.train(small(ppo, 5))


def test_training_comes_to_the_same_weights(ppo: ModuleType, address: str) -> None:
    settings = small(ppo, 2)
    with cluster(address) as connected:
        (here, curve), (there, _) = (ppo.train(settings, how) for how in (ppo.Local, partial(ppo.Remote, connected)))
    assert [point["steps"] for point in curve] == [96, 192, 288]
    for weights, other in zip(here.parameters(), there.parameters(), strict=True):
        assert torch.equal(weights, other)


@pytest.mark.nightly
def test_the_command_trains_on_a_cluster(address: str, tmp_path: Any) -> None:
    command = [sys.executable, EXAMPLE, "--quick", "--workers", "2", "--engine", "ray", "--address", address]
    done = subprocess.run([*command, "--save", "policy"], cwd=tmp_path, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "policy.safetensors").exists()
