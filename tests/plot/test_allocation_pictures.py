"""Pictures of an allocation: every tolerance, cost and limit is on them, axes have units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from cycloid_profile.effects import EFFECTS, coordinates
from cycloid_profile.plot.style import figure_holding
from cycloid_profile.plot.tolerance import cost_bars, limited_quantities, tolerance_bars
from cycloid_profile.tolerance.allocation import Allocation, SampleSizes, allocate
from cycloid_profile.tolerance.inputs import Cost, Limit, Scatter, Tolerances
from cycloid_profile.tolerance.inputs.distribution import Normal
from cycloid_profile.tolerance.study import Draws


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
    return allocate(Draws(Tolerances(scatters)), Sum(), limits, 0.8, SampleSizes(512, 1024))


def test_axes_have_units_and_titles_the_name(allocation: Allocation) -> None:
    for draw in (tolerance_bars, cost_bars, limited_quantities):
        figure = figure_holding(draw(allocation, name="A $ drive"))
        assert figure.get_suptitle().startswith(r"A \$ drive: ")
        assert all("[" in ax.get_xlabel() for ax in figure.axes)


def test_every_tolerance_and_limit_is_labelled(allocation: Allocation) -> None:
    ax = tolerance_bars(allocation, name="x")
    assert [label.get_text() for label in ax.get_yticklabels()] == [
        "pin radius error", "equidistant error", "radial moving error",
    ]  # fmt: skip
    written = [text.get_text() for text in ax.texts]
    assert written[0].startswith("±3 → ±")
    assert written[1].endswith("coarsest allowed")
    assert written[2] == "±3 µm, no cost given"
    assert len(cost_bars(allocation, name="x").get_yticklabels()) == 2
    backlash, least, force = limited_quantities(allocation, name="x")
    assert [text.get_text().strip() for text in backlash.texts] == ["≥ 0.8", "≤ 1.3"]
    assert [text.get_text().strip() for text in least.texts] == ["≥ 0"]
    assert force.get_xlabel() == "my force [n]"
    share = 100.0 * np.mean(Limit("x", 0.8, 1.3).beyond(allocation.after[:, 0]) <= 0.0)
    assert f"allocated: {share:.1f} % within" in backlash.get_legend().get_texts()[1].get_text()
