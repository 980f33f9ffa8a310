"""Learn: many environments at once, and a policy to beat, which drives in the free direction nearest to the goal's."""

import sys

import gymnasium
import numpy as np
import threewe

QUICK = "--quick" in sys.argv
ENVS = 16 if QUICK else 256
BEAMS = 72
ANGLES = np.linspace(-np.pi, np.pi, BEAMS, endpoint=False)  # [rad] of the beams, from straight ahead


def act(lidar: np.ndarray, goal: np.ndarray) -> np.ndarray:
    # free is where nothing is within 0.7 m, nor before the goal, in 30 degrees to either side
    distance, bearing = np.hypot(*goal.T), np.arctan2(goal[:, 1], goal[:, 0])
    nearest = np.min([np.roll(lidar, k, axis=1) for k in range(-6, 7)], axis=0)
    free = nearest >= np.minimum(0.7, distance)[:, None]
    aside = np.abs(np.angle(np.exp(1j * (ANGLES - bearing[:, None]))))
    way = ANGLES[np.argmin(np.where(free, aside, aside + 4.0), axis=1)]
    actions = [np.clip(np.cos(way), 0.0, 1.0) ** 2, np.zeros(ENVS), np.clip(2.0 * way, -1.0, 1.0)]
    return np.stack(actions, axis=1).astype(np.float32)


envs = gymnasium.make_vec(
    "3we/Navigation-v1",
    num_envs=ENVS,
    scene=["apartment_v1", "office_v2"],
    observations=("lidar", "goal"),
    lidar_beams=BEAMS,
    episodes="reactive",  # 2 to 8 m, without detours
    max_steps=300,
)
print(f"threewe {threewe.__version__}: {envs.single_observation_space} -> {envs.single_action_space}")

arrived, bumped, over = np.zeros((3, ENVS), bool)
observations, _ = envs.reset(seed=0)
while not over.all():
    observations, _, terminated, truncated, infos = envs.step(act(observations["lidar"], observations["goal"]))
    ends = (terminated | truncated) & ~over  # an environment's first episode counts
    arrived |= ends & infos["success"]
    bumped |= ends & (infos["collision_speed"] > 0.05)
    over |= ends
print(f"{ENVS} episodes: {arrived.mean():.0%} arrived, {bumped.mean():.0%} bumped into something")
