"""End-to-end learning: from raw lidar ranges, or from 64 x 64 pixels, and the goal to velocities; no map, no features.

    python 12_end_to_end.py --sensor lidar --steps 1000000
    python 12_end_to_end.py --sensor image --steps 200000

With --save policy.safetensors what has learned from ranges is a file that `threewe benchmark run --agent` drives.

It needs `pip install "threewe[train]"`. The networks are those that Stable-Baselines3 has for vectors and for images;
nothing about robots is in them. What such a policy reaches is in docs/how-to-train.md.
"""

import argparse
import time
from pathlib import Path

import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize
from threewe.benchmark import load_episodes, mlp_from_sb3
from threewe.gym.episodes import evaluate
from threewe.gym.sb3 import SB3VecEnv

SENSORS = {
    "lidar": {"observations": ("lidar", "goal"), "lidar_beams": 72},
    "image": {"observations": ("image", "goal"), "image_size": (64, 64)},
}
CONTROL_RATE = 5.0  # [Hz]


def train(sensor: str, steps: int, seed: int, *, num_envs: int = 128, num_scenes: int = 12) -> tuple[PPO, VecNormalize]:
    """A policy and the scale of its observations, after so many steps over all environments."""
    batch = SB3VecEnv(
        task="navigation",
        num_envs=num_envs,
        scene="procedural",
        num_scenes=num_scenes,
        scene_seed=1000 * seed,
        episodes="reactive",
        max_steps=200,
        control_rate=CONTROL_RATE,
        num_threads=2,
        **SENSORS[sensor],
    )
    vectors = [name for name in SENSORS[sensor]["observations"] if name != "image"]
    envs = VecNormalize(VecMonitor(batch), norm_obs_keys=vectors, gamma=0.98)
    settings = {"n_steps": 32, "batch_size": 8 * num_envs, "n_epochs": 4, "gamma": 0.98, "ent_coef": 0.001}
    deviation = {"log_std_init": -0.7}
    model = PPO(
        "MultiInputPolicy", envs, learning_rate=5e-4, policy_kwargs=deviation, seed=seed, device="cpu", **settings
    )
    model.learn(steps)
    return model, envs


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--sensor", choices=SENSORS, default="lidar")
    arguments.add_argument("--steps", type=int, default=1_000_000)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--save", type=Path, help="FILE.safetensors, of what learns from lidar")
    arguments.add_argument("--quick", action="store_true", help="too short to learn much")
    given = arguments.parse_args()
    if given.save and given.sensor != "lidar":
        arguments.error("--save: only the network for ranges is a feed-forward one")
    began = time.perf_counter()
    if given.quick:
        model, envs = train(given.sensor, 1_000, given.seed, num_envs=16, num_scenes=2)
    else:
        model, envs = train(given.sensor, given.steps, given.seed)
    print(f"{model.num_timesteps:,} steps in {time.perf_counter() - began:.0f} s")
    if given.save:
        mlp_from_sb3(model, envs, control_rate=CONTROL_RATE).save(given.save)

    def act(observations: dict[str, np.ndarray]) -> np.ndarray:
        actions, _ = model.predict(envs.normalize_obs(observations), deterministic=True)
        return actions

    listed = load_episodes("reactive_v1")["episodes"][:: 50 if given.quick else 5]
    options = {"control_rate": CONTROL_RATE, **SENSORS[given.sensor]}
    outcomes = evaluate(act, listed, max_steps=40 if given.quick else 300, **options)
    for scene in dict.fromkeys(episode.scene for episode in listed):
        won = [outcome.success for outcome in outcomes if outcome.episode.scene == scene]
        print(f"{scene:14} {np.mean(won):.0%} of {len(won)}")
    print(f"{'all':14} {np.mean([outcome.success for outcome in outcomes]):.1%} of {len(outcomes)}")


if __name__ == "__main__":
    main()
