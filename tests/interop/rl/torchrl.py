"""TorchRL's GymEnv, its collector, and its clipped PPO loss."""

import warnings

import numpy as np
import torch
from tensordict.nn import TensorDictModule
from tensordict.nn.distributions import NormalParamExtractor
from torch import nn
from torchrl.collectors import Collector
from torchrl.envs import GymEnv, StepCounter, TransformedEnv
from torchrl.envs.utils import check_env_specs
from torchrl.modules import ProbabilisticActor, TanhNormal, ValueOperator
from torchrl.objectives import ClipPPOLoss
from torchrl.objectives.value import GAE

BATCH = 500


class Flat(nn.Module):
    """A linear map of all that is observed, images too, in one vector."""

    def __init__(self, out: int, normal: bool) -> None:
        super().__init__()
        self.linear = nn.LazyLinear(out)
        self.parameters_of_normal = NormalParamExtractor() if normal else None

    def forward(self, *seen: torch.Tensor) -> torch.Tensor | tuple[torch.Tensor, torch.Tensor]:
        columns = [
            values.float().flatten(self.batch_dims(seen)) / (255.0 if values.dtype == torch.uint8 else 10.0)
            for values in seen
        ]
        out = self.linear(torch.cat(columns, -1))
        return out if self.parameters_of_normal is None else self.parameters_of_normal(out)

    @staticmethod
    def batch_dims(seen: tuple[torch.Tensor, ...]) -> int:
        return min(values.ndim for values in seen) - 1


def train(name: str, steps: int) -> str:
    warnings.simplefilter("error")
    torch.manual_seed(1)
    torch.set_num_threads(1)
    env = TransformedEnv(GymEnv(name), StepCounter())
    check_env_specs(env)
    keys = list(env.observation_spec.keys())
    keys.remove("step_count")
    size = env.action_spec.shape[-1]
    network = TensorDictModule(Flat(2 * size, normal=True), in_keys=keys, out_keys=["loc", "scale"])
    policy = ProbabilisticActor(
        network,
        in_keys=["loc", "scale"],
        spec=env.action_spec,
        distribution_class=TanhNormal,
        distribution_kwargs={"low": -1.0, "high": 1.0},
        return_log_prob=True,
    )
    value = ValueOperator(Flat(1, normal=False), in_keys=keys)
    start = env.reset()
    policy(start)
    value(start)
    advantage = GAE(gamma=0.99, lmbda=0.95, value_network=value)
    loss = ClipPPOLoss(actor_network=policy, critic_network=value)
    optimizer = torch.optim.Adam(loss.parameters(), lr=3e-4)
    collector = Collector(
        env, policy, frames_per_batch=BATCH, total_frames=steps, auto_register_policy_transforms=False
    )
    frames, rewards = 0, []
    for batch in collector:
        advantage(batch)
        losses = loss(batch)
        total = losses["loss_objective"] + losses["loss_critic"] + losses["loss_entropy"]
        assert torch.isfinite(total)
        optimizer.zero_grad()
        total.backward()
        optimizer.step()
        frames += batch.numel()
        rewards.append(batch["next", "reward"].mean().item())
    collector.shutdown()
    assert frames >= steps
    return f"PPO {BATCH * np.mean(rewards):.2f} in {BATCH} steps"
