"""Keys of `[drive]`: pins, disc, and how the disc is held and driven."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from cycloid_profile.spec.table import LENGTH, SIZE, Table, key


def _stiffness_of(bearing: str) -> Meta:
    return key(f"Radial stiffness of {bearing} [N/mm].", "give a stiffness such as 4.0e5", ge=1.0, le=1e12)


def _play_of(bearing: str) -> Meta:
    return key(
        f"Radial play of {bearing}, half the diametral clearance [µm].",
        "give half the diametral clearance, 0 for none",
        ge=0,
        le=1000,
    )


class CranksSpec(Table, frozen=True):
    """Crank shafts of an RV reducer. Without this table one central eccentric carries the discs."""

    count: Annotated[int, key("Number of crank shafts.", "give 2 or 3 crank shafts", ge=2, le=12)]
    circle_radius_mm: Annotated[float, key("Radius of the circle the crank shafts stand on [mm].", LENGTH, **SIZE)]
    bearing_stiffness_n_per_mm: Annotated[float, _stiffness_of("each crank bearing")] = 4.0e5
    bearing_play_um: Annotated[float, _play_of("each crank bearing")] = 0.0


class EccentricSpec(Table, frozen=True):
    """The central eccentric, where there are no crank shafts."""

    bearing_stiffness_n_per_mm: Annotated[float, _stiffness_of("the eccentric bearing")] = 4.0e5
    bearing_play_um: Annotated[float, _play_of("the eccentric bearing")] = 0.0


class FirstStageSpec(Table, frozen=True):
    """Involute first stage. Without this table the eccentric is the input."""

    sun_teeth: Annotated[int, key("Teeth of the sun z1.", "give the number of teeth of the sun", ge=3, le=1000)]
    planet_teeth: Annotated[int, key("Teeth of a planet z2.", "give the number of teeth of a planet", ge=3, le=1000)]
    module_mm: Annotated[float, key("Module of the first stage [mm].", LENGTH, **SIZE)]


class DriveSpec(Table, frozen=True):
    """Pins, disc and how the disc is held."""

    pins: Annotated[int, key("Number of pins z_p; the disc has one lobe less.", "give 3 to 1000 pins", ge=3, le=1000)]
    pin_circle_radius_mm: Annotated[
        float, key("Radius of the circle through the pin centres r_p [mm].", LENGTH, **SIZE)
    ]
    pin_radius_mm: Annotated[float, key("Radius of a pin r_rp [mm].", LENGTH, **SIZE)]
    eccentricity_mm: Annotated[float, key("Eccentricity a [mm].", LENGTH, **SIZE)]
    disc_width_mm: Annotated[float, key("Face width b of one disc [mm].", "give the face width of one disc", **SIZE)]
    discs: Annotated[int, key("Number of discs, evenly phased.", "give 1, 2 or 3 discs", ge=1, le=6)]
    cranks: CranksSpec | None = None
    eccentric: EccentricSpec = EccentricSpec()
    first_stage: FirstStageSpec | None = None
