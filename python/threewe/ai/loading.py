"""Loading of policies: a folder of ours, or a checkpoint of LeRobot's ACT, whose translation is kept in it."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

from threewe._arguments import as_file
from threewe._extras import needed_for
from threewe.ai.checkpoint import CONFIG, PROCESSORS, TRANSLATED, WEIGHTS, Checkpoint, is_checkpoint, read_checkpoint
from threewe.ai.child import start_child
from threewe.ai.engine import Engine, GraphEngine
from threewe.ai.folder import EMBEDDED, Policy, read_policy, write_policy
from threewe.ai.hub import local_policy
from threewe.ai.naming import Naming, Rename, naming_of, policy_of
from threewe.ai.remote import connect_policy
from threewe.errors import ConfigError

TRANSLATION = 1
"""Of checkpoints into graphs: another number makes kept ones stale."""
ENSEMBLE = "temporal_ensemble_coeff"


def open_policy(
    source: str | os.PathLike[str],
    rename: Rename | None = None,
    rate: float | None = None,
    dataset: str | os.PathLike[str] | None = None,
    python: str | os.PathLike[str] | None = None,
    revision: str | None = None,
) -> tuple[Policy, Engine]:
    """A policy and what computes its actions. Raises ConfigError, ContractError, ConnectionError."""
    if isinstance(source, str) and source.startswith(("grpc://", "grpcs://")):
        raise ConfigError(
            f"{source}: LeRobot's policy server unpickles what it is sent, so that anyone who reaches it may run code: "
            "it is not spoken to; serve the policy with threewe policy serve, and pass ws://host:port"
        )
    if isinstance(source, str) and source.startswith(("ws://", "wss://")):
        if python is not None or dataset is not None or revision is not None:
            raise ConfigError(f"{source}: a server has its own: leave out python=, dataset= and revision=")
        return connect_policy(source, naming_of(rename, rate, None, source))
    folder = as_file("folder", local_policy(source, revision))
    if python is not None:
        return start_child(folder, python, naming_of(rename, rate, dataset, folder))
    policy, graph = load_policy(folder, rename, rate, dataset)
    return policy, engine_of(policy, graph)


def load_policy(
    folder: Path,
    rename: Rename | None = None,
    rate: float | None = None,
    dataset: str | os.PathLike[str] | None = None,
) -> tuple[Policy, bytes]:
    """The policy of a folder, ours or LeRobot's, and its graph. Raises ConfigError."""
    if not is_checkpoint(folder):
        for name, given in (("rename", rename), ("rate", rate), ("dataset", dataset)):
            if given is not None:
                raise ConfigError(f"{folder}: policy.json says everything: leave out {name}=, which other formats need")
        return _read(folder)
    naming = naming_of(rename, rate, dataset, folder)
    checkpoint = read_checkpoint(folder)
    kept = checkpoint.folder / f"threewe-{_digest(checkpoint, naming)}"
    if kept.is_dir():
        return _read(kept)
    policy, graph = translate(checkpoint, naming)
    try:
        write_policy(replace(policy, folder=kept), graph)
    except OSError:  # it cannot be kept: the next time it is translated again
        with tempfile.TemporaryDirectory() as elsewhere:
            write_policy(replace(policy, folder=Path(elsewhere, "policy")), graph)
            return _read(Path(elsewhere, "policy"))
    for stale in checkpoint.folder.glob("threewe-*"):
        if stale != kept:
            shutil.rmtree(stale, ignore_errors=True)
    return _read(kept)


def convert_checkpoint(
    folder: Path,
    output: Path,
    rename: Rename | None = None,
    rate: float | None = None,
    dataset: str | os.PathLike[str] | None = None,
) -> None:
    """Writes the policy's folder of a checkpoint of LeRobot's ACT. Raises ConfigError."""
    if output.exists():
        raise ConfigError(f"output: {output} exists already")
    if not is_checkpoint(folder):
        files = ", ".join((CONFIG, WEIGHTS, *PROCESSORS))
        raise ConfigError(f"{folder}: no checkpoint of LeRobot, which has {files}")
    policy, graph = translate(read_checkpoint(folder), naming_of(rename, rate, dataset, folder))
    write_policy(replace(policy, folder=output), graph)
    read_policy(output)


def _read(folder: Path) -> tuple[Policy, bytes]:
    policy = read_policy(folder)
    return policy, policy.graph.read_bytes()


def engine_of(policy: Policy, graph: bytes) -> Engine:
    """What runs a policy of a folder. Raises ConfigError."""
    if policy.features is None:
        return GraphEngine(policy, graph)
    from threewe.ai.hailo import HailoEngine

    return HailoEngine(policy, graph)


def _digest(checkpoint: Checkpoint, naming: Naming) -> str:
    """Of all that a translation depends on."""
    digest = hashlib.blake2b(f"{TRANSLATION} {naming}".encode(), digest_size=8)
    states = [step.state.name for step in (*checkpoint.before, *checkpoint.after) if step.state is not None]
    for name in (CONFIG, WEIGHTS, *PROCESSORS, *states):
        with (checkpoint.folder / name).open("rb") as content:
            while part := content.read(2**22):
                digest.update(part)
    return digest.hexdigest()


def translate(checkpoint: Checkpoint, naming: Naming) -> tuple[Policy, bytes]:
    """A policy and its graph. Raises ConfigError."""
    with needed_for("translating a checkpoint", "policy"):
        import onnx  # noqa: F401

        from threewe.ai.act import act_graph, read_act_config
    fields = checkpoint.fields()
    if checkpoint.kind != "act":
        raise fields.fail(
            "type",
            f"'{checkpoint.kind}' is not translated, only 'act': run it in LeRobot's own environment with "
            f"python='/path/to/lerobot/bin/python'",
        )
    _check_steps(checkpoint)
    config = read_act_config(checkpoint)
    merge = "replace" if checkpoint.config.get(ENSEMBLE) is None else "ensemble"
    policy = policy_of(checkpoint, naming, config.chunk, merge, EMBEDDED in checkpoint.inputs)
    return policy, act_graph(checkpoint, config, policy)


def _check_steps(checkpoint: Checkpoint) -> None:
    """Raises ConfigError where a processor does what is not translated."""
    for step in (*checkpoint.before, *checkpoint.after):
        if step.name not in TRANSLATED:
            raise step.place.fail("registry_name", f"'{step.name}' is not translated")
        if step.config.get("float_dtype") not in (None, "float32"):
            raise step.place.fail("config.float_dtype", f"must be float32, got {step.config['float_dtype']!r}")
