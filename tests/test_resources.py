"""Needs of large inputs: stated above a tenth of a limit, refused above it, met where that is allowed."""

from __future__ import annotations

import pytest

from cycloid_profile.errors import ResourceError
from cycloid_profile.resources import LIMITS, Need, is_large_allowed, resource_limits


@pytest.mark.parametrize("name", LIMITS)
def test_a_need_is_silent_stated_or_refused_by_its_share_of_the_limit(name):
    most, said = LIMITS[name].most, []
    with resource_limits(say=said.append):
        Need("points", 7, "take fewer", **{name: 0.05 * most}).require()
        assert not said
        Need("points", 7, "take fewer", **{name: 0.5 * most}).require()
        assert len(said) == 1
        with pytest.raises(ResourceError, match=r"^points = 7 needs about .*limit .* add --allow-large$"):
            Need("points", 7, "take fewer", **{name: 2.0 * most}).require()


def test_what_is_allowed_is_stated_and_the_permission_ends_with_its_context():
    need, said = Need("points", 7, "take fewer", memory=2.0 * LIMITS["memory"].most), []
    with resource_limits(allow_large=True, say=said.append):
        assert is_large_allowed()
        need.require()
    assert said == ["points = 7 needs about 8 GB of memory"]
    assert not is_large_allowed()
    with pytest.raises(ResourceError):
        need.require()


@pytest.mark.parametrize("size", [1, 6, 1000])
def test_blocks_of_poses_bound_their_matrices_and_leave_small_drives_whole(size):
    from cycloid_profile.contact._blocks import BLOCK, poses_per_block

    assert poses_per_block(80) == BLOCK
    assert 1 <= poses_per_block(2 * 1000) < BLOCK
    assert 8.0 * poses_per_block(10 * size) * (10 * size) ** 2 <= max(2.6e8, 8.0 * (10 * size) ** 2)
