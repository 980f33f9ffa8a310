"""How long policies take to think, and what a robot's control ticks notice of it."""

import asyncio
import random
import time
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from threewe import Robot, Velocity
from threewe.ai import VLARunner

from verify.cases import act_checkpoints
from verify.harness import Case

TICK = 0.02  # [s]
DEFAULT = {"chunk_size": 100, "n_action_steps": 100, "dim_model": 512, "n_heads": 8, "dim_feedforward": 3200}
LAYERS = {"latent_dim": 32, "n_encoder_layers": 4, "n_decoder_layers": 1, "n_vae_encoder_layers": 4}
SIZES = {"ACT 240x320": (240, 320), "ACT 480x640": (480, 640)}
POLICIES = ("goto_v1", *SIZES)
_FOLDER = TemporaryDirectory()


@cache
def _folder(policy: str) -> Path:
    """A checkpoint of LeRobot's default ACT with drawn weights."""
    shape = act_checkpoints.Shape(*SIZES[policy], state=0, text=False, options={**DEFAULT, **LAYERS})
    return act_checkpoints.write(Path(_FOLDER.name, policy.replace(" ", "-")), shape)


def _runner(policy: str) -> VLARunner:
    """An ACT of some size, or the shipped policy."""
    if policy == "goto_v1":
        return VLARunner.from_pretrained(policy)
    return VLARunner.from_pretrained(_folder(policy), rate=10, rename={"action": ["vx", "vy", "omega"]})


def infer(seed: int, policy: str) -> Case:
    """CPU time [ms] of an inference on one thread, and [s] of loading, which for ACT is translating."""
    if policy != "goto_v1":
        _folder(policy)
    begun = time.process_time()
    runner = _runner(policy)
    loading = time.process_time() - begun
    camera = runner.policy.cameras[0]
    picture = np.random.default_rng(seed).integers(0, 256, (camera.height, camera.width, 3), np.uint8)
    instruction = "go to the chair" if runner.policy.language else ""
    times = []
    for _ in range(5 + (100 if policy == "goto_v1" else 10)):
        begun = time.thread_time()
        runner.predict_chunk(picture, instruction, velocity=Velocity())
        times.append(time.thread_time() - begun)
    return {"policy": policy, "ms": 1e3 * float(np.median(times[5:])), "loading": loading}


def drive(seed: int, policy: str, seconds: float) -> Case:
    """A robot in real time with its camera on: commands of the policy's a second, and ticks that come a period late.

    What the control thread waits for a processor, because there are too few for all that runs, is left out: the rest is
    its own work, and locks that others hold.
    """
    runner = _runner(policy)
    camera = runner.policy.cameras[0]
    scene = random.Random(seed).choice(["office_v2", "apartment_v1", "warehouse_v1"])
    instruction = "go to the chair" if runner.policy.language else ""

    async def measured() -> Case:
        async with Robot(scene=scene, seed=seed, realtime=True, image_size=(camera.height, camera.width)) as robot:
            stamps: list[float] = []
            robot.observe(lambda _: stamps.append(time.monotonic() - _waited()))
            await robot.sleep(seconds)
            alone = _late(stamps)
            stamps.clear()
            inferences, guided, driven, reasons = 0, 0.0, 0.0, set()
            end = robot.now + seconds
            while robot.now < end - 0.1:
                result = await runner.run(robot, instruction, timeout=end - robot.now)
                inferences += result.inferences
                guided += result.guided
                driven += result.duration
                reasons.add(result.reason)
            ticks = len(stamps)
            return {
                "policy": policy,
                "ticks": ticks,
                "late": _late(stamps),
                "late_alone": alone,
                "commands": guided / TICK / seconds,
                "unguided": driven - guided,
                "inferences": inferences / seconds,
                "reasons": sorted(reasons),
            }

    return asyncio.run(measured())


def _waited() -> float:
    """[s] that this thread could have run, and had no processor (Linux)."""
    return int(Path("/proc/thread-self/schedstat").read_text().split()[1]) / 1e9


def _late(stamps: list[float]) -> int:
    return int((np.diff(stamps) > 2 * TICK).sum())
