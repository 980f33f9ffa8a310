"""openpi's own client gets from our server what the policy gives here. `./dev interop openpi`."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import numpy as np
from ai import policies
from threewe.ai import VLARunner
from threewe.ai.serving import PolicyServer


def test_its_client_gets_our_actions(tmp_path: Path) -> None:
    runner = VLARunner.from_pretrained(policies.write(tmp_path / "policy", policies.graph((0.1, 0.0, 0.2), red=0.5)))
    random = np.random.default_rng(1)
    pictures = random.integers(0, 256, (20, policies.HEIGHT, policies.WIDTH, 3), np.uint8)  # BGR
    given, out = tmp_path / "given.npz", tmp_path / "out.npz"
    np.savez(given, **{f"{i}/observation.images.camera": each[:, :, ::-1] for i, each in enumerate(pictures)})
    words = [os.environ["OPENPI_PYTHON"], str(Path(__file__).with_name("peer.py"))]
    with PolicyServer(runner) as server:
        said = subprocess.run(
            [*words, server.address, str(given), "go to the chair", str(out)],
            capture_output=True,
            text=True,
            timeout=120,
        )
    assert said.returncode == 0, said.stderr
    assert said.stdout.strip() == "3we-policy"
    with np.load(out) as found:
        for i, picture in enumerate(pictures):
            expected = runner.predict_chunk(picture, "go to the chair")
            np.testing.assert_allclose(found[str(i)], expected, rtol=0, atol=1e-6)
