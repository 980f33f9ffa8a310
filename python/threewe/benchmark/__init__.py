"""Benchmarks: frozen episodes, metrics and baselines.

from threewe import RobotProfile, Scene, SceneTables
from threewe.benchmark import optimistic_replanning, spl

profile = RobotProfile.load("3we_standard_v2")
tables = SceneTables(Scene.load("office_v2"), profile)
episode = tables.sample_episode(1)
best = optimistic_replanning(tables, profile, episode.start, episode.goal)
print(spl(best.reached, episode.geodesic, best.length))
"""

from threewe._core import ReferenceDrive, ReferenceExploration, nearest_frontier, optimistic_replanning, spl
from threewe.benchmark.episodes import Episode, EpisodeSet, Outcome, Yardstick, load_episodes

__all__ = [
    "Episode",
    "EpisodeSet",
    "Outcome",
    "ReferenceDrive",
    "ReferenceExploration",
    "Yardstick",
    "load_episodes",
    "nearest_frontier",
    "optimistic_replanning",
    "spl",
]
