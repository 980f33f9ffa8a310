"""Commit subjects say where and what: `area: verb object`, so that `git log --oneline | grep nav` works."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
LAST_WITHOUT = "ddfa505"  # the rule holds for what came after
SUBJECT = re.compile(r"[a-z][a-z0-9_+-]*: [a-z].*[^.]")


def bad(subject: str) -> bool:
    return len(subject) > 72 or SUBJECT.fullmatch(subject) is None


def test_subjects_are_area_verb_object() -> None:
    log = ["git", "log", "--no-merges", "--format=%s", f"{LAST_WITHOUT}..HEAD"]
    done = subprocess.run(log, cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        pytest.skip("no history here: a shallow clone, or none at all")
    assert [subject for subject in done.stdout.splitlines() if bad(subject)] == []


@pytest.mark.parametrize(
    "subject", ["Fixes a bug", "nav, slam: do both", "nav: Do it", "nav: do it.", "nav: " + "a" * 70]
)
def test_other_subjects_are_found(subject: str) -> None:
    assert bad(subject)
