"""RLlib's PPO on the plain environment, whose dictionaries its own connector flattens."""

import warnings

import numpy as np
import ray
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.connectors.env_to_module import FlattenObservations
from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig

BATCH = 500


def train(name: str, steps: int) -> str:
    warnings.filterwarnings("error", module="gymnasium|threewe")
    ray.init(num_cpus=1, include_dashboard=False, log_to_driver=False, configure_logging=False)
    config = (
        PPOConfig()
        .environment(name)
        .env_runners(
            num_env_runners=0,
            num_envs_per_env_runner=2,
            env_to_module_connector=lambda env=None, spaces=None, device=None: FlattenObservations(),  # noqa: ARG005
        )
        .training(train_batch_size_per_learner=BATCH, minibatch_size=BATCH, num_epochs=1)
        .rl_module(model_config=DefaultModelConfig(fcnet_hiddens=[32]))
        .debugging(seed=1)
    )
    algorithm = config.build_algo()
    for _ in range(steps // BATCH):
        result = algorithm.train()
    sampled = result["num_env_steps_sampled_lifetime"]
    reward = result["env_runners"]["episode_return_mean"]
    algorithm.stop()
    ray.shutdown()
    assert sampled >= steps
    assert np.isfinite(reward)
    return f"PPO {reward:.2f}"
