"""Texts of spec files that many tests write."""

from __future__ import annotations

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
