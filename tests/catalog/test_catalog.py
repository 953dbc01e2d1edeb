"""Every drive of the catalogue reads, can be built, and says what is assumed of it."""

from __future__ import annotations

import msgspec
import pytest

from cycloid_profile.catalog import catalog_drive, catalog_names, catalog_text
from cycloid_profile.design.from_spec import conventional_profile, disc_outline, drive_of, load_case
from cycloid_profile.errors import SpecError


def test_the_catalogue_holds_the_published_sizes_and_a_printed_drive() -> None:
    assert {"rv20e_like", "rv40e", "rv80e", "printed_11"} <= set(catalog_names())


@pytest.mark.parametrize("name", catalog_names())
def test_a_drive_has_a_source_and_lists_its_assumptions(name: str) -> None:
    spec = catalog_drive(name)
    assert spec.source.reference
    assert spec.source.assumed
    assert catalog_text(name).startswith("#:schema ")


@pytest.mark.parametrize("name", catalog_names())
def test_a_drive_can_be_made(name: str) -> None:
    spec = catalog_drive(name)
    drive = drive_of(spec)
    outline = disc_outline(spec, drive, conventional_profile(spec, drive))
    assert outline.root_radius == pytest.approx(
        drive.trochoid.pin_circle_radius - drive.trochoid.eccentricity - drive.pin_radius
        - 1e-3 * (spec.modification.equidistant_um + spec.modification.radial_moving_um)
    )  # fmt: skip


def test_ratios_of_the_makers_catalogue() -> None:
    # RV-40E 121 and RV-20E 81 are printed on the type plates; RV-80E follows from its published teeth, 153.
    ratios = {name: drive_of(catalog_drive(name)).reduction_ratio for name in ("rv20e_like", "rv40e", "rv80e")}
    assert ratios == pytest.approx({"rv20e_like": 81.0, "rv40e": 121.0, "rv80e": 153.0})


def test_an_unknown_drive_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(SpecError, match=r"did you mean rv40e\?"):
        catalog_drive("RV4O")
    with pytest.raises(SpecError, match="known are printed_11"):
        catalog_drive("###")


@pytest.mark.parametrize(("discs", "share"), [(1, 1.0), (2, 0.55), (3, 1.1 / 3)])
def test_one_disc_carries_all_and_two_the_published_share(discs: int, share: float) -> None:
    spec = catalog_drive("printed_11")
    spec = msgspec.structs.replace(spec, drive=msgspec.structs.replace(spec.drive, discs=discs))
    drive = drive_of(spec)
    assert load_case(spec, drive, drive.theoretical_profile).disc_share == pytest.approx(share)


@pytest.mark.parametrize(("name", "full"), [("rv20e", "rv20e_like"), ("RV-40E", "rv40e"), ("printed", "printed_11")])
def test_the_beginning_of_a_name_is_enough(name: str, full: str) -> None:
    assert catalog_text(name) == catalog_text(full)


def test_a_beginning_of_several_names_lists_them() -> None:
    with pytest.raises(SpecError, match=r"choose from rv20e_like, rv40e, rv80e"):
        catalog_text("rv")
