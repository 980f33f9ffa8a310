"""Kinds of rows: how cases become what a test sees, and rows about some of the cases or parts of them."""

import math
import statistics
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from verify.harness.counts import Always, Rate, Share
from verify.harness.means import Counted, GeometricMean, Mean
from verify.harness.rows import Case, KnownMiss, Row, Seen


def share_of(name: str, holds: Callable[[Case], bool], *, at_least: float) -> Row:
    """The share of cases in which something holds; of all of them where `at_least` is 1."""

    def seen(parts: list[Case]) -> Seen:
        return float(sum(bool(holds(part)) for part in parts)), float(len(parts))

    if at_least >= 1.0:
        return Row(name, seen, Always())
    return Row(name, seen, Share(at_least))


def all_of(name: str, holds: Callable[[Case], bool]) -> Row:
    """Something holds in every case."""
    return share_of(name, holds, at_least=1.0)


def worst_of(name: str, value: Callable[[Case], float], **target: float) -> Row:
    """Every case is `at_least` or `at_most` something; the worst of them is shown too."""
    bound, at_least = sense(target)

    def words(parts: list[Case]) -> str:
        worst = (min if at_least else max)(value(part) for part in parts)
        return f"worst {worst:.4g}, wanted {'>=' if at_least else '<='} {bound:g}"

    row = all_of(name, lambda part: value(part) >= bound if at_least else value(part) <= bound)
    return replace(row, words=words)


def mean_of(name: str, value: Callable[[Case], float], *, form: str = "{:.3g}", **target: float) -> Row:
    """The mean over the cases is `at_least` or `at_most` something."""
    bound, at_least = sense(target)

    def seen(parts: list[Case]) -> Seen:
        return mean_and_error([value(part) for part in parts])

    return Row(name, seen, Mean(bound, at_least, form))


def time_of(name: str, value: Callable[[Case], float], **target: float) -> Row:
    """The geometric mean of timings, or of paces."""
    bound, at_least = sense(target)

    def seen(parts: list[Case]) -> Seen:
        return mean_and_error([math.log(max(value(part), 1e-12)) for part in parts])

    return Row(name, seen, GeometricMean(bound, at_least))


def ratio_of(
    name: str,
    value: Callable[[Case], float],
    reference: Callable[[Case], float],
    *,
    form: str = "{:.3f}",
    **target: float,
) -> Row:
    """The sum over the cases as a share of that of a reference in the same cases."""
    bound, at_least = sense(target)

    def seen(parts: list[Case]) -> Seen:
        return *ratio_and_error([(value(part), reference(part)) for part in parts]), float(len(parts))

    def words(parts: list[Case]) -> str:
        return f"{sum(map(value, parts)):g} of {sum(map(reference, parts)):g}"

    return Row(name, seen, Mean(bound, at_least, form), words=words)


def counted_of(
    name: str, hits: Callable[[Case], float], of: Callable[[Case], float], *, form: str = "{:.1%}", **target: float
) -> Row:
    """The share of what each case counts; what is counted in one case may be alike, cases are not. All of it is right
    where `at_least` is 1.
    """
    bound, at_least = sense(target)
    if at_least and bound >= 1.0:
        return Row(name, lambda parts: (float(sum(map(hits, parts))), float(sum(map(of, parts)))), Always())

    def seen(parts: list[Case]) -> Seen:
        counted = [(hits(part), of(part)) for part in parts if of(part) > 0]
        return *ratio_and_error(counted), float(len(counted)), float(sum(of for _, of in counted))

    return Row(name, seen, Counted(bound, at_least, form))


def share_within(
    name: str, parts: Callable[[Case], Iterable[Case]], holds: Callable[[Case], bool], *, at_least: float
) -> Row:
    """The share of parts of cases, such as the drives in one place, in which something holds."""
    if at_least >= 1.0:
        return within(all_of(name, holds), parts)
    row = counted_of(
        name,
        lambda case: sum(bool(holds(part)) for part in parts(case)),
        lambda case: sum(1 for _ in parts(case)),
        at_least=at_least,
    )
    return replace(row, parts=lambda case: [case] if any(True for _ in parts(case)) else [])


def rate_of(name: str, events: Callable[[Case], float], exposure: Callable[[Case], float], *, at_most: float) -> Row:
    """How often something comes, in the exposure of all cases."""

    def seen(parts: list[Case]) -> Seen:
        return float(sum(map(events, parts))), float(sum(map(exposure, parts)))

    return Row(name, seen, Rate(at_most))


def whole_of(name: str, judge: Callable[[list[Case]], tuple[str, str, bool | None]]) -> Row:
    """A figure of all cases together, of which no part is a test: its target, and whether it is met. Judged where all
    cases of the experiment have been run.
    """
    return Row(name, whole=judge)


def info(name: str, figure: Callable[[list[Case]], str]) -> Row:
    """A figure beside those that have a target."""
    return Row(name, whole=lambda parts: (figure(parts), "", None))


def within(row: Row, parts: Callable[[Case], Iterable[Case]]) -> Row:
    """The row about parts of cases."""
    return replace(row, parts=parts)


def where(row: Row, holds: Callable[[Case], bool]) -> Row:
    """The row about those cases, or parts, for which something holds: the row's name says so."""
    return replace(row, parts=lambda case: [part for part in row.parts(case) if holds(part)])


def each(key: str, values: Iterable[Any], row: Callable[[Any], Row]) -> list[Row]:
    """A row for each value of an argument of the cases."""
    return [
        replace(where(made, lambda part, value=value: part[key] == value), name=f"{made.name}, {value}")
        for value in values
        for made in [row(value)]
    ]


def known_miss(row: Row, bar: float | None, why: str) -> Row:
    """The row, whose figure on file is the bar and misses the target; as it is where there is no bar."""
    return row if bar is None else replace(row, known_miss=KnownMiss(why, bar))


def sense(target: dict[str, float]) -> tuple[float, bool]:
    """The bound, and whether it is one from below."""
    ((word, bound),) = target.items()
    return bound, {"at_least": True, "at_most": False}[word]


def ratio_and_error(pairs: list[tuple[float, float]]) -> tuple[float, float]:
    """The ratio of two sums, and its standard error."""
    of = statistics.fmean(reference for _, reference in pairs)
    if of == 0.0:
        raise ValueError("the reference is zero in all cases")
    ratio = statistics.fmean(value for value, _ in pairs) / of
    return ratio, mean_and_error([(value - ratio * reference) / of for value, reference in pairs])[1]


def mean_and_error(values: list[float]) -> Seen:
    """A mean, its standard error, and of how many."""
    count = len(values)
    error = statistics.stdev(values) / math.sqrt(count) if count > 1 else math.inf
    return statistics.fmean(values), error, float(count)
