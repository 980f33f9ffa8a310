"""The harness of `./dev verify`, from the bottom up:

distributions   tails
sequential      samples and the record against a target: when they give the alarm
counts, means   the tests: what they catch
rows            claims: what cases show, judged by a test
kinds           kinds of rows, and rows about some of the cases
journal         finished cases, the commit and the seed that follows from it
running         experiments, whose cases the runner of benchmarks runs in processes of their own
record          what samples of earlier commits saw
claims          results of full runs, and the page that is made of them
area            all of that, for one area
"""

from verify.harness.kinds import (
    all_of,
    counted_of,
    each,
    info,
    known_miss,
    mean_of,
    rate_of,
    ratio_of,
    share_of,
    share_within,
    time_of,
    where,
    whole_of,
    within,
    worst_of,
)
from verify.harness.rows import Case, Row, Verdict
from verify.harness.running import Experiment

__all__ = [
    "Case",
    "Experiment",
    "Row",
    "Verdict",
    "all_of",
    "counted_of",
    "each",
    "info",
    "known_miss",
    "mean_of",
    "rate_of",
    "ratio_of",
    "share_of",
    "share_within",
    "time_of",
    "where",
    "whole_of",
    "within",
    "worst_of",
]
