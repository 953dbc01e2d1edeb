"""Pictures of an allocation: every tolerance, cost and limit is on them, axes have units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from cycloid_profile.effects.coordinates import coordinates
from cycloid_profile.effects.registry import EFFECTS
from cycloid_profile.plot.allocation import cost_bars, limited_quantities, tolerance_bars
from cycloid_profile.tolerance.allocated import Allocation
from cycloid_profile.tolerance.allocation import Effort, allocate
from cycloid_profile.tolerance.distribution import Normal
from cycloid_profile.tolerance.draws import Draws
from cycloid_profile.tolerance.limits import Limit
from cycloid_profile.tolerance.scatter import Cost, Scatter, Tolerances


@dataclass(frozen=True)
class Sum:
    """A backlash, its least, and a quantity without a description; some reducers have no answer."""

    names: tuple[str, ...] = ("backlash_arcmin", "least_backlash_arcmin", "my_force_n")

    def of(self, x: np.ndarray) -> np.ndarray:
        total = np.where(x[:, 0] > 3.0, np.nan, 1.0 + 0.1 * np.sum(x, axis=1))
        return np.stack([total, total - 0.5, 100.0 * total], axis=1)


@pytest.fixture(scope="module")
def allocation() -> Allocation:
    costs = {"pin_radius_error": Cost(1.0), "equidistant_error": Cost(50.0, coarsest=1.1), "radial_moving_error": None}
    scatters = tuple(
        Scatter(kind=EFFECTS[name], axes=coordinates(EFFECTS[name]), choices=({},), size=Normal(0.0, 1.0),
                angle_deg=None, plus_minus=3.0, cost=cost, label=name)
        for name, cost in costs.items()
    )  # fmt: skip
    limits = (
        Limit("backlash_arcmin", 0.8, 1.3),
        Limit("least_backlash_arcmin", 0.0),
        Limit("my_force_n", at_most=150.0),
    )
    return allocate(Draws(Tolerances(scatters)), Sum(), limits, 0.8, Effort(512, 1024))


def test_axes_have_units_and_titles_the_name(allocation: Allocation) -> None:
    for draw in (tolerance_bars, cost_bars, limited_quantities):
        figure = draw(allocation, "A $ drive")
        assert figure.get_suptitle().startswith(r"A \$ drive: ")
        assert all("[" in ax.get_xlabel() for ax in figure.axes)


def test_every_tolerance_and_limit_is_told(allocation: Allocation) -> None:
    ax = tolerance_bars(allocation, "x").axes[0]
    assert [label.get_text() for label in ax.get_yticklabels()] == [
        "pin radius error", "equidistant error", "radial moving error",
    ]  # fmt: skip
    told = [text.get_text() for text in ax.texts]
    assert told[0].startswith("±3 → ±")
    assert told[1].endswith("coarsest allowed")
    assert told[2] == "±3 µm, no cost given"
    assert len(cost_bars(allocation, "x").axes[0].get_yticklabels()) == 2
    backlash, least, force = limited_quantities(allocation, "x").axes
    assert [text.get_text().strip() for text in backlash.texts] == ["≥ 0.8", "≤ 1.3"]
    assert [text.get_text().strip() for text in least.texts] == ["≥ 0"]
    assert force.get_xlabel() == "my force [n]"
    share = 100.0 * np.mean(Limit("x", 0.8, 1.3).beyond(allocation.after[:, 0]) <= 0.0)
    assert f"allocated: {share:.1f} % within" in backlash.get_legend().get_texts()[1].get_text()
