"""What comes with Stable-Baselines3: processes, normalisation, stacks of frames, evaluation, saved models, videos."""

import tempfile
import warnings
from pathlib import Path

import gymnasium
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import CheckpointCallback, EvalCallback
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import (
    SubprocVecEnv,
    VecEnv,
    VecFrameStack,
    VecNormalize,
    VecTransposeImage,
    VecVideoRecorder,
)


def train(name: str, steps: int) -> str:
    warnings.simplefilter("error")
    torch.set_num_threads(1)
    with tempfile.TemporaryDirectory() as folder:
        return train_in(Path(folder), name, steps)


def vector(name: str, **options: object) -> VecEnv:
    """Two processes, each with episodes of 100 steps, of which two are seen at a time."""
    envs = make_vec_env(
        f"threewe:{name}",  # which processes that start from nothing know too
        n_envs=2,
        seed=3,
        vec_env_cls=SubprocVecEnv,
        env_kwargs={"max_steps": 100, **options},
        monitor_kwargs={"info_keywords": ("success", "path_length")},
    )
    return VecTransposeImage(VecFrameStack(envs, n_stack=2))


def train_in(folder: Path, name: str, steps: int) -> str:
    envs = VecNormalize(vector(name), norm_obs_keys=["lidar"])
    judge = VecNormalize(vector(name), norm_obs_keys=["lidar"], training=False, norm_reward=False)
    model = PPO("MultiInputPolicy", envs, n_steps=250, batch_size=125, n_epochs=1, seed=1, device="cpu")
    callbacks = [
        EvalCallback(judge, eval_freq=500, n_eval_episodes=2, best_model_save_path=str(folder), verbose=0),
        CheckpointCallback(save_freq=500, save_path=str(folder), name_prefix="kept"),
    ]
    model.learn(steps, callback=callbacks)
    episode = model.ep_info_buffer[-1]
    assert episode["l"] <= 100
    assert episode["path_length"] >= 0.0
    assert (folder / "best_model.zip").exists()

    # the same policy again, on the same episodes
    model.save(folder / "model")
    envs.save(str(folder / "normalize.pkl"))
    again = PPO.load(folder / "model", device="cpu")
    plain = VecNormalize.load(str(folder / "normalize.pkl"), vector(name))
    plain.training = plain.norm_reward = False
    observation = plain.reset()
    np.testing.assert_array_equal(
        model.predict(observation, deterministic=True)[0], again.predict(observation, deterministic=True)[0]
    )
    reward, _ = evaluate_policy(again, plain, n_eval_episodes=2)
    again.set_env(plain)
    again.learn(500)

    film(folder / "video", name, again)
    for one in (envs, judge, plain):
        one.close()
    monitored = Monitor(gymnasium.make(name, max_steps=3), str(folder / "log"))
    monitored.reset(seed=1)
    for _ in range(3):
        *_, truncated, info = monitored.step(np.zeros(3, np.float32))
    assert truncated
    assert info["episode"]["l"] == 3
    monitored.close()
    return f"PPO, SubprocVecEnv, VecNormalize, VecFrameStack, EvalCallback, save, load, video: {reward:.2f}"


def film(folder: Path, name: str, model: PPO) -> None:
    envs = VecVideoRecorder(vector(name, render_mode="rgb_array"), str(folder), lambda step: step == 0, video_length=10)
    observations = envs.reset()
    for _ in range(11):
        observations, *_ = envs.step(model.predict(observations)[0])
    envs.close()
    assert list(folder.glob("*.mp4"))
