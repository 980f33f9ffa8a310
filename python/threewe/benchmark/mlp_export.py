"""Feed-forward policies of PyTorch and of Stable-Baselines3 as `MlpPolicy`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe.benchmark.mlp import MlpPolicy
from threewe.errors import ConfigError

ACTIVATIONS = {"Tanh": "tanh", "ReLU": "relu", "ELU": "elu", "SiLU": "silu"}  # by their classes in torch.nn
IGNORED = ("Identity", "Flatten", "Dropout")  # which do nothing to a vector when a policy drives


def mlp_from_torch(network: Iterable[Any], observations: Mapping[str, int], **fields: Any) -> MlpPolicy:
    """A policy of a `torch.nn.Sequential` of `Linear` layers with one kind of activation between them.

    Args:
        network: its modules, in order. An activation after the last layer is the policy's `output_activation`.
        observations: what its inputs are: lengths by name, in their order.
        fields: of `MlpPolicy`, such as `mean`, `standard_deviation` and `control_rate`.

    Raises ConfigError for a network of other parts.
    """
    layers: list[tuple[NDArray[Any], NDArray[Any]]] = []
    between: list[str] = []  # the activation after each layer
    for module in _flat(network):
        kind = type(module).__name__
        if kind == "Linear":
            layers.append(_linear(module))
            between.append("none")
        elif kind in ACTIVATIONS and between and between[-1] == "none":
            if kind == "ELU" and module.alpha != 1.0:
                raise ConfigError(f"network: ELU with alpha {module.alpha} has no place in a feed-forward policy")
            between[-1] = ACTIVATIONS[kind]
        elif kind not in IGNORED:
            raise ConfigError(f"network: {kind} has no place in a feed-forward policy: export it as an ONNX graph")
    hidden = set(between[:-1]) or {"tanh"}
    if len(hidden) > 1:
        raise ConfigError(f"network: its activations differ ({', '.join(sorted(hidden))}): export it as an ONNX graph")
    last = between[-1] if between else "none"
    return MlpPolicy(observations, layers, activation=hidden.pop(), output_activation=last, **fields)


def mlp_from_sb3(model: Any, normalization: Any = None, **fields: Any) -> MlpPolicy:
    """The policy of an on-policy algorithm of Stable-Baselines3 (PPO, A2C), without its noise.

    Args:
        model: trained with `MultiInputPolicy` on named observations without images, in [-1, 1]^3.
        normalization: the `VecNormalize` that it was trained in, where there was one.
        fields: of `MlpPolicy`: `control_rate` is not in a model.

    Raises ConfigError for a policy that is none of a feed-forward network.
    """
    policy, space = model.policy, model.observation_space
    if not hasattr(space, "spaces") or not hasattr(policy, "mlp_extractor") or hasattr(policy, "lstm_actor"):
        raise ConfigError("model: expected one of PPO or A2C with MultiInputPolicy on named observations")
    if policy.squash_output:
        raise ConfigError("model: squashed outputs have no place in a feed-forward policy")
    observations = {name: int(np.prod(one.shape)) for name, one in space.spaces.items()}
    scales = {} if normalization is None else _scales(normalization, observations)
    network = [*policy.mlp_extractor.policy_net, policy.action_net]
    return mlp_from_torch(network, observations, **scales, **fields)


def _scales(normalization: Any, observations: Mapping[str, int]) -> dict[str, Any]:
    """Means and standard deviations (inputs,) of a `VecNormalize`; in the order of the inputs."""
    if not normalization.norm_obs:
        return {}
    normalized = normalization.norm_obs_keys or list(observations)
    if set(normalized) != set(observations):
        raise ConfigError("normalization: clips some observations alone: normalize all of them, or none")
    moments = normalization.obs_rms
    spread = [np.sqrt(moments[name].var + normalization.epsilon) for name in observations]
    return {
        "mean": np.concatenate([moments[name].mean.ravel() for name in observations]),
        "standard_deviation": np.concatenate([one.ravel() for one in spread]),
        "input_clip": float(normalization.clip_obs),
    }


def _flat(network: Iterable[Any]) -> Iterable[Any]:
    for module in network:
        if type(module).__name__ == "Sequential":
            yield from _flat(module)
        else:
            yield module


def _linear(module: Any) -> tuple[NDArray[Any], NDArray[Any]]:
    weight = module.weight.detach().cpu().numpy()
    return weight, np.zeros(len(weight)) if module.bias is None else module.bias.detach().cpu().numpy()
