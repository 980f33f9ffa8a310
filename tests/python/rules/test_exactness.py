"""Results are the same bits on every machine: nothing fused, nothing approximate, no libm."""

import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]

# Their bits differ between instruction sets, or between C libraries. src/core/exact.hpp has what to use instead.
FORBIDDEN = re.compile(
    r"\b(MulAdd|MulSub|NegMulAdd|NegMulSub|MulAddSub|ApproximateReciprocal|ApproximateReciprocalSqrt)\b"
    r"|\bstd::(fma|fmaf|sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|exp|exp2|expm1|log|log2|log10|log1p|pow|hypot"
    r"|cbrt|erf|erfc|tgamma|lgamma|reduce|transform_reduce)\b"
    r"|(?<![\w:.>])(fma|sinf?|cosf?|tanf?|atan2f?|expf?|logf?|powf?|hypotf?)\("
)


def test_sources_call_nothing_inexact() -> None:
    wrong = [
        f"{file.relative_to(ROOT)}:{line}: {match[0]}"
        for folder in ("include/threewe", "src")
        for file in sorted((ROOT / folder).rglob("*.[ch]pp"))
        if not (file.parent.name == "core" and file.stem.startswith("exact"))
        for line, text in enumerate(file.read_text().splitlines(), 1)
        if (match := FORBIDDEN.search(code(text)))
    ]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("y = hn::MulAdd(a, b, c);", True),
        ("y = std::atan2(s, c);", True),
        ("y = sin(x);", True),
        ("y = exact::sin(x);", False),
        ("y = pose.sin(x);  // not std::sin", False),
        ("y = cosine(x);", False),
    ],
)
def test_the_rule_can_tell(text: str, found: bool) -> None:
    assert bool(FORBIDDEN.search(code(text))) == found


def test_no_source_is_compiled_with_fused_products() -> None:
    commands = {
        Path(entry["file"]): entry["command"].split()
        for entry in json.loads((ROOT / "build/dev/compile_commands.json").read_text())
    }
    library = {file: flags for file, flags in commands.items() if file.is_relative_to(ROOT / "src")}
    assert library
    for file, flags in library.items():
        assert [flag for flag in flags if flag.startswith("-ffp-contract")] == ["-ffp-contract=off"], file
        assert "-DEIGEN_DONT_VECTORIZE" in flags, file
        assert not {"-ffast-math", "-Ofast", "-march=native", "-funsafe-math-optimizations"} & set(flags), file


def code(line: str) -> str:
    """A line without its comment."""
    return line.split("//")[0]
