"""Episodes of the shipped policy, whose network's answers are on file.

The bits of a network depend on the processor. So a drive takes the answers that are on file as long as those that its
network gives are the same but for rounding: then it is the same to the bit on every processor. From the first answer
on that is another one, because the network or what it is shown has changed, it takes those of the network.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from verify.pairs.outcomes import Outcome, of_attempt

if TYPE_CHECKING:
    from threewe.ai.runner import VLARunner

ANSWERS = Path(__file__).resolve().parents[1] / "baseline/answers"
ROUNDING = 1e-3
"""What answers of two processors may differ by, in standard deviations of the actions."""


class Answers:
    """Stands between a network and its policy: gives the answers on file while the network's are the same."""

    def __init__(self, runner: VLARunner, path: Path) -> None:
        """Takes the place of the runner's own way from an answer to actions."""
        self.path = path
        self.given: list[NDArray[np.float32]] = []
        self._kept = np.load(path) if path.exists() else np.zeros((0,), np.float32)
        self._same = True
        self._actions = runner._actions
        runner._actions = self  # type: ignore[method-assign, assignment]

    def __call__(self, answer: NDArray[np.float32], committed: Sequence[Any] = ()) -> NDArray[np.float64]:
        """Returns the actions of one answer."""
        k = len(self.given)
        self._same = self._same and k < len(self._kept) and bool(np.abs(answer - self._kept[k]).max() <= ROUNDING)
        self.given.append(self._kept[k] if self._same else answer)
        return self._actions(self.given[-1], committed)

    def save(self) -> None:
        """Puts the answers of this drive on file."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        np.save(self.path, np.array(self.given, np.float32))


def of_policy(scene: str, index: int, renew: bool = False) -> Outcome:
    """Returns the outcome of a frozen episode of a thing in sight."""
    from threewe.ai.agent import PolicyAgent
    from threewe.benchmark.attempt import Settings, attempt_with
    from threewe.benchmark.episodes import load_episodes

    listed = [episode for episode in load_episodes("in_sight_v1")["episodes"] if episode.scene == scene]
    agent = PolicyAgent("goto_v1")
    answers = Answers(agent._runner, ANSWERS / f"goto_v1-{scene}-{index}.npy")
    tried = attempt_with("objectnav", listed[index], agent, Settings())
    if renew:
        answers.save()
    return of_attempt(tried)
