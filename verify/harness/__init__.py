"""The harness of `./dev verify`, from the bottom up:

distributions   tails
rows            claims: what cases show, judged by a test
counts, means   the tests: what meets a target, and what a run would catch
kinds           kinds of rows, and rows about some of the cases
journal         finished cases, the commit and the seed that follows from it
running         experiments, whose cases the runner of benchmarks runs in processes of their own
claims          results of full runs, and the page that is made of them
area            experiments of any areas: run, judged and printed
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
