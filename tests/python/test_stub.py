"""The checked-in types of the C++ module are those that it has."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.skipif(sys.version_info[:2] != (3, 11), reason="not shown: the stub is compared on Python 3.11")
def test_stub_is_up_to_date() -> None:
    generated = (ROOT / "build/dev/_core.pyi").read_text()
    checked_in = (ROOT / "python/threewe/_core.pyi").read_text()
    assert generated == checked_in, "the bindings have changed: ./dev build --stub"
