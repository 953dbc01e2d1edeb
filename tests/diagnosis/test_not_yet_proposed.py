"""Effects that can be simulated before diagnosis proposes them: no file of theirs is explained by their name."""

from __future__ import annotations

from pathlib import Path

from cycloid_profile.diagnosis.model.candidate import NOT_YET_PROPOSED, OF_PLASTICS, candidates
from cycloid_profile.effects import EFFECTS
from tests.diagnosis.correcting import drawn

PAGE = Path(__file__).parents[2] / "docs" / "diagnosis.md"


def test_the_library_has_the_effects_it_was_validated_with() -> None:
    assert set(EFFECTS) > NOT_YET_PROPOSED
    for scanned, curves in ((frozenset({0, 1}), False), (frozenset(), True), (frozenset({0}), True)):
        names = {one.name for one in candidates(drawn(), scanned, curves)}
        assert names
        assert not names & NOT_YET_PROPOSED
    # All effects but chatter, which the spectrum proposes, and a displaced pin, which is another name of a thick one.
    assert {one.name for one in candidates(drawn(), frozenset({0}), True)} == set(
        EFFECTS
    ) - NOT_YET_PROPOSED - OF_PLASTICS - {
        "grinding_chatter",
        "pin_position_error",
    }


def test_the_page_says_so() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert all(f"`{name}`" in text for name in NOT_YET_PROPOSED)
