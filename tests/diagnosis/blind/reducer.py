"""The reducer of the drawing: the numbers of its spec file."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Reducer:
    """Numbers of a spec file, RV-40E unless given; keys carry their unit.

    No ``cranks`` is a central eccentric without a first stage. ``disc_body`` is what the spec file says of the discs.
    ``body_twist_arcmin``: what elastic discs add to the twist at rated torque, by finite elements, mean over the poses.
    """

    name: str = "RV-40E"
    pins: int = 40
    pin_circle_radius_mm: float = 64.0
    pin_radius_mm: float = 3.0
    eccentricity_mm: float = 1.3
    disc_width_mm: float = 11.5
    discs: int = 2
    cranks: int = 3
    crank_circle_radius_mm: float = 36.0
    bearing_stiffness_n_per_mm: float = 4.0e5
    sun_teeth: int = 12
    planet_teeth: int = 36
    module_mm: float = 1.5
    youngs_modulus_gpa: float = 206.0
    poisson_ratio: float = 0.3
    rated_torque_nm: float = 412.0
    equidistant_um: float = 6.0
    radial_moving_um: float = 0.0
    compensation_um: float = 0.0
    disc_body: str = "rigid"
    body_twist_arcmin: float = 0.135

    @property
    def lobes(self) -> int:
        """z_c, one less than the pins."""
        return self.pins - 1

    @property
    def short_width_ratio(self) -> float:
        """K1 = a z_p / r_p."""
        return self.eccentricity_mm * self.pins / self.pin_circle_radius_mm

    @property
    def period(self) -> float:
        """Phase once round the disc, 2π z_c."""
        return 2.0 * math.pi * self.lobes

    @property
    def contact_compliance(self) -> float:
        """C_E of pin and tooth, both of one material [1/MPa]."""
        return 2.0 * (1.0 - self.poisson_ratio**2) / (1e3 * self.youngs_modulus_gpa)

    @property
    def crank_per_carrier(self) -> float:
        """Turn of a crank against the housing for one turn of the carrier, input held; none of a central eccentric."""
        return 0.0 if self.cranks == 0 else 1.0 + self.sun_teeth / self.planet_teeth

    @property
    def planet_radius_mm(self) -> float:
        """Pitch radius of a planet."""
        return 0.5 * self.module_mm * self.planet_teeth


def spec_text(reducer: Reducer) -> str:
    """The spec file of the reducer, as TOML."""
    r = reducer
    compensation = "false" if r.compensation_um == 0.0 else repr(r.compensation_um)
    material = f"youngs_modulus_gpa = {r.youngs_modulus_gpa}\npoisson_ratio = {r.poisson_ratio}\n"
    return f"""name = "{r.name}"

[drive]
pins = {r.pins}
pin_circle_radius_mm = {r.pin_circle_radius_mm}
pin_radius_mm = {r.pin_radius_mm}
eccentricity_mm = {r.eccentricity_mm}
disc_width_mm = {r.disc_width_mm}
discs = {r.discs}

{_support(r)}
[materials.disc]
{material}
[materials.pin]
{material}
[load]
rated_torque_nm = {r.rated_torque_nm}
disc_body = "{r.disc_body}"

[modification]
equidistant_um = {r.equidistant_um}
radial_moving_um = {r.radial_moving_um}
deformation_compensation = {compensation}
"""


def _support(r: Reducer) -> str:
    """Tables of what carries the discs."""
    if not r.cranks:
        return f"[drive.eccentric]\nbearing_stiffness_n_per_mm = {r.bearing_stiffness_n_per_mm}\n"
    return f"""[drive.cranks]
count = {r.cranks}
circle_radius_mm = {r.crank_circle_radius_mm}
bearing_stiffness_n_per_mm = {r.bearing_stiffness_n_per_mm}

[drive.first_stage]
sun_teeth = {r.sun_teeth}
planet_teeth = {r.planet_teeth}
module_mm = {r.module_mm}
"""


# Drives of one to three kilograms to two hundred: few and many lobes, two and three cranks, a central eccentric.
REDUCERS: dict[str, Reducer] = {
    "11 lobes": Reducer(
        "11 lobes", 12, 45.0, 5.0, 2.2, 12.0, 2, 2, 22.0, 3.0e5, 12, 36, 0.9, rated_torque_nm=60.0,
        equidistant_um=12.0, body_twist_arcmin=0.07,
    ),
    "19 lobes, eccentric": Reducer(
        "19 lobes, eccentric", 20, 40.0, 2.5, 1.1, 9.0, 2, 0, 0.0, 2.0e5, rated_torque_nm=50.0,
        equidistant_um=9.0, body_twist_arcmin=0.149,
    ),
    "29 lobes": Reducer(
        "29 lobes", 30, 52.0, 3.0, 1.2, 10.0, 2, 2, 28.0, 3.0e5, 10, 34, 1.27, rated_torque_nm=167.0,
        equidistant_um=7.0, body_twist_arcmin=0.16,
    ),
    "39 lobes": Reducer(),
    "59 lobes": Reducer(
        "59 lobes", 60, 110.0, 3.5, 1.3, 17.0, 2, 3, 62.0, 7.0e5, 15, 45, 2.07, rated_torque_nm=1225.0,
        equidistant_um=9.0, body_twist_arcmin=0.124,
    ),
}  # fmt: skip
