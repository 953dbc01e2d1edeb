"""Texts of spec files that many tests write."""

from __future__ import annotations

from pathlib import Path

DRIVE = """[drive]
pins = 40
pin_circle_radius_mm = 64.0
pin_radius_mm = 3.0
eccentricity_mm = 1.3
disc_width_mm = 11.5
discs = 2
"""
CRANKS = """[drive.cranks]
count = 3
circle_radius_mm = 36.0
"""
FIRST_STAGE = """[drive.first_stage]
sun_teeth = 12
planet_teeth = 36
module_mm = 1.5
"""
RV40E = f"""name = "RV-40E"
{DRIVE}{CRANKS}{FIRST_STAGE}[load]
rated_torque_nm = 412.0
disc_body = "rigid"
[modification]
equidistant_um = 6.0
"""
# The example with rigid discs, which are designed eight times as fast: where files and sentences are asked, not loads.
RIGID_EXAMPLE = (
    (Path(__file__).parents[1] / "examples" / "rv40e.toml")
    .read_text(encoding="utf-8")
    .replace("[load]\n", '[load]\ndisc_body = "rigid"\n')
)
# One disc of eleven pins on a central eccentric, no torque given.
PLAIN = """name = "plain"
[drive]
pins = 11
pin_circle_radius_mm = 30.0
pin_radius_mm = 3.0
eccentricity_mm = 1.5
disc_width_mm = 8.0
discs = 1
[modification]
equidistant_um = 20.0
"""
# A printed actuator of 13:1 as published: pins, sizes and clearance are known, materials assumed.
PRINTED = """name = "printed actuator 13 to 1"
[drive]
pins = 14
pin_circle_radius_mm = 34.0
pin_radius_mm = 3.5
eccentricity_mm = 1.5
disc_width_mm = 12.5
discs = 2
[materials.disc]
youngs_modulus_gpa = 3.5
poisson_ratio = 0.38
[materials.pin]
youngs_modulus_gpa = 3.5
poisson_ratio = 0.38
[load]
rated_torque_nm = 25.0
[modification]
equidistant_um = 50.0
"""
# Further line of [modification], with which a text ends.
UNCOMPENSATED = "deformation_compensation = false\n"
