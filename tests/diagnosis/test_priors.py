"""Prior widths: ISO 286-1, a published printed actuator, an RV-40E, scaling with size and load, quality of manufacture.

Standard tolerances: ISO 286-1:2010, Table 1 [µm]. The standard computes each step of D at the geometric mean of its
limits and rounds, to about 10 % in small steps; below IT6 its values leave the series, see ``standard_tolerance``.

Printed actuator: 14 pins, carbon-filled polymer, measured in "Anti-Backlash Mechanisms for Cost-Effective Cycloidal
Drive Robotic Actuators" (MSc thesis, repository JelmerV/Anti-Backlash-Cycloidal-Actuator, CC BY-SA 4.0). A fit by hand
of its loops to ±25 N·m gives Coulomb friction of 4 N·m, 0.1 to 0.16 N·m/′ in series and 0.2 mm more clearance.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.laws import Material
from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import Priors, candidate_of, candidates, priors_of
from cycloid_profile.diagnosis.model.candidate import IMPLAUSIBLE
from cycloid_profile.diagnosis.model.optimum import Optimum
from cycloid_profile.diagnosis.model.priors import PRIORS, stage_scales, standard_tolerance
from cycloid_profile.effects import (
    EFFECTS,
    AsBuiltReducer,
    CoulombFriction,
    CrankBearingClearance,
    CrankBearingCompliance,
    CrankPhaseError,
    DiscRunout,
    Effect,
    EffectLocation,
    EquidistantError,
    MissingDeformationCompensation,
    NonlinearSeriesCompliance,
    PinCircleRadiusError,
    PinRadiusError,
    SeriesCompliance,
    as_drawn,
    coordinates,
)
from cycloid_profile.effects.base import size_field
from cycloid_profile.errors import LoadError, SpecError
from cycloid_profile.geometry import CentralEccentric, Cranks, Drive, InvoluteStage, Trochoid
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.spec import parse_spec
from cycloid_profile.units import UM
from tests.spec_texts import PLAIN, PRINTED, RV40E

PAGE = Path(__file__).parents[2] / "docs" / "diagnosis.md"
ELASTIC_RV40E = RV40E.replace('disc_body = "rigid"\n', "")
TABLE_1 = {  # IT5 to IT13 [µm] of the steps of D [mm]
    (3.0, 6.0): (5, 8, 12, 18, 30, 48, 75, 120, 180),
    (18.0, 30.0): (9, 13, 21, 33, 52, 84, 130, 210, 330),
    (50.0, 80.0): (13, 19, 30, 46, 74, 120, 190, 300, 460),
    (120.0, 180.0): (18, 25, 40, 63, 100, 160, 250, 400, 630),
    (315.0, 400.0): (25, 36, 57, 89, 140, 230, 360, 570, 890),
}
# Widths that were twice the manufacturing tolerance of an RV-40E, and at least so much where it is a length [µm].
OLD_LEAST_UM = 1.5
FAR_FROM_OLD = {"nonlinear_series_compliance": 2.15}  # the twist of the other series compliance, from the same table


@cache
def built(text: str) -> AsBuiltReducer:
    return as_built_reducer(parse_spec(text))


def width(kind: type[Effect], priors: Priors) -> float:
    axes = coordinates(kind, frozenset({"waves_per_turn"} & set(kind.__dataclass_fields__)))  # type: ignore[attr-defined]
    return priors.width(kind, axes.size, axes.reciprocal)


@pytest.mark.parametrize("step", TABLE_1, ids=str)
def test_standard_tolerances(step):
    found = [standard_tolerance(grade, math.sqrt(math.prod(step))) / UM for grade in range(5, 14)]
    assert found[1:] == pytest.approx(TABLE_1[step][1:], rel=0.12)
    assert found[0] == pytest.approx(TABLE_1[step][0], rel=0.16)


@given(dimension=st.floats(0.5, 60.0), grade=st.integers(1, 14))
def test_eight_times_the_dimension_doubles_the_cube_root_part(dimension, grade):
    linear = 10.0 ** ((grade - 1) / 5.0) * 0.001 * dimension * UM
    small, large = standard_tolerance(grade, dimension), standard_tolerance(grade, 8.0 * dimension)
    assert large - 8.0 * linear == pytest.approx(2.0 * (small - linear), rel=1e-9)


@pytest.mark.parametrize(
    ("kind", "coordinate"),
    [
        (CoulombFriction, 4.0),
        (SeriesCompliance, 1.0 / 0.16),
        (SeriesCompliance, 1.0 / 0.1),
        (EquidistantError, 200.0),
        (CrankBearingClearance, 200.0),
    ],
    ids=lambda value: value.name if isinstance(value, type) else f"{value:.3g}",
)
def test_a_printed_actuator_is_plausible(kind, coordinate):
    printed, ground = priors_of(built(PRINTED)), priors_of(built(f'quality = "ground"\n{PRINTED}'))
    assert coordinate < IMPLAUSIBLE * width(kind, printed)
    assert coordinate > IMPLAUSIBLE * width(kind, ground)


@pytest.mark.parametrize("name", EFFECTS)
def test_an_rv40e_keeps_its_widths_within_a_factor_of_two(name):
    kind = EFFECTS[name]
    axes = coordinates(kind, frozenset({"waves_per_turn"} & set(kind.__dataclass_fields__)))
    tolerance = axes.size.tolerance
    old = 2.0 / tolerance if axes.reciprocal else 2.0 * tolerance
    if axes.size.name.endswith("_um"):
        old = max(old, OLD_LEAST_UM)
    factor = FAR_FROM_OLD.get(name, 2.0)
    assert old / factor < width(kind, priors_of(built(ELASTIC_RV40E))) < old * factor


def test_the_published_rigidity_of_an_rv40e_is_plausible():
    # Catalogue 108 N·m/′ against the simulated stage: 134 N·m/′ in series (docs/articles.md).
    assert width(SeriesCompliance, priors_of(built(ELASTIC_RV40E))) > 1.0 / 134.0


def test_every_effect_of_the_library_has_its_rule():
    assert set(PRIORS) == set(EFFECTS.values())


def test_a_plug_in_effect_has_twice_its_tolerance():
    @dataclass(frozen=True)
    class ClampedInThreeJaws(Effect):
        location = EffectLocation.FLANK
        amplitude_um: float = size_field("amplitude [µm]", 0.4, 0.0, 50.0)

    @dataclass(frozen=True)
    class SoftFoundation(Effect):
        location = EffectLocation.COMPLIANCE
        linear_in_reciprocal = True
        stiffness_nm_per_arcmin: float = size_field("stiffness [N·m/′]", 50.0, 1.0, 1e6)

    for text in (RV40E, PRINTED):
        priors = priors_of(built(text))
        assert candidate_of(ClampedInThreeJaws, {}, priors).width == pytest.approx(0.8)
        assert candidate_of(SoftFoundation, {}, priors).width == pytest.approx(2.0 / 50.0)


def test_quality_comes_from_the_materials():
    assert priors_of(built(RV40E)).quality == "ground"
    assert (priors_of(built(PRINTED)).quality, priors_of(built(PRINTED)).pin_quality) == ("printed", "printed")
    plain = built(PLAIN)
    plastic = replace(plain, case=replace(plain.case, disc_material=Material(3000.0, 0.36)))
    assert priors_of(plastic).quality == "printed"
    # Steel pins in a printed disc are bought.
    assert priors_of(plastic).pin_quality == "machined"
    assert width(PinRadiusError, priors_of(plastic)) < 0.1 * width(PinCircleRadiusError, priors_of(plastic))


@pytest.mark.parametrize("quality", ["ground", "machined", "printed"])
def test_quality_of_the_spec_decides(quality):
    for text in (RV40E, PRINTED):
        assert priors_of(built(f'quality = "{quality}"\n{text}')).quality == quality


def test_an_unknown_quality_is_refused():
    with pytest.raises(SpecError, match=r"quality.*ground, machined, printed"):
        parse_spec(f'quality = "cast"\n{RV40E}')


def test_a_coarser_quality_is_never_narrower():
    for kind in EFFECTS.values():
        widths = [width(kind, priors_of(built(f'quality = "{q}"\n{RV40E}'))) for q in ("ground", "machined", "printed")]
        assert widths == sorted(widths), kind.name


def _drawn(scale: float, torque: float) -> AsBuiltReducer:
    """An RV-40E of steel ``scale`` times as large in every length."""
    stage = InvoluteStage(12, 36, 1.5 * scale)
    drive = Drive(
        Trochoid(40, 64.0 * scale, 1.3 * scale), 3.0 * scale, 11.5 * scale, 2, Cranks(3, 36.0 * scale, 4e5), stage
    )
    return as_drawn(LoadCase(drive, modify(drive.theoretical_profile, Equidistant(0.006 * scale)), torque))


def test_widths_scale_with_size_and_load():
    small, large = priors_of(_drawn(1.0, 412e3)), priors_of(_drawn(2.0, 8.0 * 412e3))
    # Lengths grow with a little more than the cube root, the angle of such a length therefore falls.
    assert 2.0 ** (1 / 3) < width(DiscRunout, large) / width(DiscRunout, small) < 1.4
    assert 0.5 * 2.0 ** (1 / 3) < width(CrankPhaseError, large) / width(CrankPhaseError, small) < 0.7
    assert width(CoulombFriction, large) == pytest.approx(8.0 * width(CoulombFriction, small))
    # The twist of a share of the stage, and the compliance that gives it.
    twist = width(NonlinearSeriesCompliance, large) / width(NonlinearSeriesCompliance, small)
    assert width(SeriesCompliance, large) / width(SeriesCompliance, small) == pytest.approx(twist / 8.0)


def test_a_stage_twice_as_stiff_expects_half_the_compliance():
    def priors(modulus: float, stiffness: float, torque: float) -> Priors:
        drive = Drive(Trochoid(11, 30.0, 1.5), 3.0, 8.0, 2, CentralEccentric(stiffness))
        material = Material(modulus, 0.3)
        case = LoadCase(drive, modify(drive.theoretical_profile, Equidistant(0.02)), torque, material, material)
        return priors_of(as_drawn(case))

    # Moduli and torque doubled: the same deflections.
    soft, stiff = priors(1.0e5, 4.0e5, 4e4), priors(2.0e5, 8.0e5, 8e4)
    assert width(SeriesCompliance, stiff) == pytest.approx(0.5 * width(SeriesCompliance, soft), rel=1e-6)
    assert width(MissingDeformationCompensation, stiff) == pytest.approx(
        width(MissingDeformationCompensation, soft), rel=1e-6
    )


@pytest.mark.parametrize(("text", "most"), [(RV40E, 2.45), (PRINTED, 2.05), (PLAIN, 2.05)])
def test_bearings_of_this_compliance_double_that_of_the_stage(text, most):
    reducer = built(text)
    priors = priors_of(reducer)
    share = 3.0 if priors.quality == "printed" else 0.5
    softer = reducer.with_bearings(softer=width(CrankBearingCompliance, priors) / share * 1e-6)  # µm/kN to mm/N
    # The radial force of the discs adds to the moment on the cranks of an RV reducer.
    assert 1.95 < stage_scales(softer).compliance / stage_scales(reducer).compliance < most


def test_a_stage_without_equilibrium_is_refused_with_the_reason():
    reducer = _drawn(1.0, 412e3)
    far = replace(reducer, case=replace(reducer.case, torque=1e15))
    with pytest.raises(LoadError, match="rated torque"):
        width(SeriesCompliance, priors_of(far))


def test_candidates_have_these_widths():
    reducer = built(PRINTED)
    listed = {one.name: one for one in candidates(reducer, frozenset(), True)}
    for name in ("coulomb_friction", "series_compliance", "equidistant_error"):
        assert listed[name].width == width(EFFECTS[name], priors_of(reducer))


def test_the_page_has_these_widths():
    """Rows of docs/diagnosis.md, "Priors": the last two cells are the widths of the RV-40E and the printed actuator."""
    section = PAGE.read_text(encoding="utf-8").split("### Priors")[1].split("\n## ")[0]
    rows = [line.strip("| ").split(" | ") for line in section.splitlines() if re.match(r"\| `", line)]
    found = {}
    for cells in rows:
        for name in re.findall(r"`(\w+)`", cells[0]):
            assert name not in found
            found[name] = [float(re.match(r"[\d.]+", cell)[0]) for cell in cells[-2:]]  # type: ignore[index]
    assert set(found) == set(EFFECTS)
    for name, shown in found.items():
        expected = [width(EFFECTS[name], priors_of(built(text))) for text in (ELASTIC_RV40E, PRINTED)]
        assert shown == pytest.approx(expected, rel=0.006), name


@pytest.mark.parametrize("degrees", [0.0, 90.0, 143.0, 217.0, 270.0])
@pytest.mark.parametrize("share", [0.999, 1.001])
def test_a_fit_is_implausible_by_its_size_at_any_angle(degrees, share):
    # The second of two members is as large as is plausible, or a little larger; the first is small.
    members = tuple(c for c in candidates(built(ELASTIC_RV40E), frozenset({0}), False) if c.angle is not None)[:2]
    size, angle = share * IMPLAUSIBLE, math.radians(degrees)
    u = np.array([0.1, 0.1, size * math.cos(angle), size * math.sin(angle)])
    found = Optimum(members, u, np.eye(4), np.eye(4), 1.0, 1.0, 100, 0.0, True)
    assert found.implausible == (share > 1.0)
    # Coordinates in the unit of the size: widths of the prior, and their squares.
    np.testing.assert_allclose(np.hypot(*found.coordinates(1)), share * members[1].implausible)
    np.testing.assert_allclose(found.covariance_of(1), np.eye(2) * members[1].width ** 2)
