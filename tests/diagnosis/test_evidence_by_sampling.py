"""Evidence of Eq. (53) compared with sampling of the exact model, on two cheap cases.

``python -m tests.diagnosis.sampled_evidence`` runs all of them.
"""

from __future__ import annotations

import pytest

from tests.diagnosis.sampled_evidence import CASES, weighed

_LIVE_POINTS = 60
# Error of the Gaussian approximation on a nearly linear model.
_NEAR = 0.3


@pytest.mark.slow
@pytest.mark.parametrize(("name", "one_sided"), [("equidistant_error", 0), ("flank_wear", 1)])
def test_evidence_agrees_with_sampling(name, one_sided):
    (question,) = (q for q in CASES if q.asked["names"] == (name,) and q.label == "scan, small")
    (answer,) = weighed(question, ("true",), _LIVE_POINTS)
    assert answer.one_sided == one_sided
    assert abs(answer.local - answer.laplace) < 5.0 * answer.local_error < 0.15
    assert abs(answer.nested - answer.laplace) < 3.0 * answer.nested_error + _NEAR
