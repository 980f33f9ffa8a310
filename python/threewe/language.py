"""Commands in English, read offline: a lexicon and a grammar, no model and no network."""

from __future__ import annotations

import re
from collections.abc import Iterable

from threewe import _core
from threewe._arguments import as_list, as_text
from threewe._core import Reading, ReadingOutcome, RefusalRule, Skill, Step, ThingPhrase

__all__ = ["Reading", "ReadingOutcome", "RefusalRule", "Skill", "Step", "ThingPhrase", "read_command"]


def read_command(text: str, places: Iterable[str] = ()) -> Reading:
    """Reads what a sentence such as "go to the kitchen and find the red chair" asks of a robot.

    The same text always has the same meaning. What has several comes back as `ambiguous`, and what cannot be read as
    `not_understood` with the word; nothing is guessed. One letter that is wrong, missing, doubled or swapped is mended
    in words of four letters and more, where one known word alone is that near.

    Args:
        text: at most 1,000 characters.
        places: names of the places that the robot knows, as they were given; it always knows `start`.

    Raises:
        ContractError: no text, one that is too long, or a place without a name.
    """
    names = [as_text(f"places[{i}]", place) for i, place in enumerate(as_list("places", places))]
    return _core.read_command(encodable(as_text("text", text)), [encodable(name) for name in names])


def encodable(text: str) -> str:
    """The same text; halves of characters, which no UTF-8 has, are replaced."""
    return re.sub("[\ud800-\udfff]", "\ufffd", text)
