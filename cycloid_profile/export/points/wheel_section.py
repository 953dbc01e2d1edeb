"""Profile of a form wheel that grinds one gap, and the path of its dresser.

The gap is a cylinder along the axis of the disc, ground by moving the wheel along it. The axis of the wheel lies at
x_root + R on the x axis and is swivelled by λ from the transverse plane. A point of the gap is ground where its normal
meets the axis of the wheel: z = tanλ (y − (x − x_root − R) n_y/n_x).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves import Deviation, ProfileSource
from cycloid_profile.export.points.layouts import chosen_points, template_lines
from cycloid_profile.export.points.tables import POINT_RESOLUTION, read_table, write_table
from cycloid_profile.export.writing import WrittenFile
from cycloid_profile.spec.model import FormWheelSpec, PointsSpec
from cycloid_profile.units import DEGREE

FILENAME, _TEMPLATE_FILENAME = "form_wheel.csv", "form_wheel.txt"


@dataclass(frozen=True, eq=False, slots=True)
class FormWheel:
    """Axial section of a wheel, complex ``section`` z + iρ with z along its axis and radius ρ [mm], its outward
    ``normal``, and the centre of the ``dresser`` [mm]; shape (points,) all."""

    section: ComplexArray
    normal: ComplexArray
    dresser: ComplexArray


def form_wheel(source: ProfileSource, settings: FormWheelSpec) -> FormWheel:
    """Wheel for the gap at lobe 1, from tip to tip.

    Raises ``ExportError`` if the wheel would cut into the flanks, or its dresser does not fit its profile.
    """
    points = chosen_points(source, PointsSpec(range="gap"))
    swivel, radius = settings.inclination_deg * DEGREE, settings.wheel_radius_mm
    p, n = points.position, points.normal
    axis_x = float(np.max(np.real(source.profile.at(0.0).position))) + radius
    off = p.real - axis_x
    along = math.tan(swivel) * (p.imag - off * n.imag / n.real)
    axial = p.imag * math.cos(swivel) + along * math.sin(swivel)
    rho = np.sqrt(np.maximum(off**2 + p.imag**2 + along**2 - axial**2, 0.0))
    # The normal of the wheel is that of the gap, reversed, in the plane through the axis of the wheel.
    normal_axial = -n.imag * math.cos(swivel)
    normal_radial = np.sqrt(np.maximum(1.0 - normal_axial**2, 0.0))
    section, normal = axial + 1j * rho, normal_axial + 1j * normal_radial
    if not (np.all(np.diff(axial) < 0.0) or np.all(np.diff(axial) > 0.0)):
        raise ExportError(
            "export.form_wheel.inclination_deg", f"{settings.inclination_deg:g}", "makes the wheel cut into the flanks",
            "swivel it less, or take a smaller wheel",
        )  # fmt: skip
    dresser = section + settings.dresser_radius_mm * normal
    step = np.diff(dresser) * np.conj(np.diff(section))
    if settings.dresser_radius_mm and not np.all(step.real > 0.0):
        raise ExportError(
            "export.form_wheel.dresser_radius_mm", f"{settings.dresser_radius_mm:g}",
            "does not fit the concave parts of the wheel", "take a smaller tip",
        )  # fmt: skip
    return FormWheel(section, normal, dresser)


def write_form_wheel(source: ProfileSource, settings: FormWheelSpec, folder: Path) -> tuple[WrittenFile, ...]:
    """Write the section and, with a template, the dresser's program; the section, read back, is measured on the gap."""
    wheel = form_wheel(source, settings)
    columns = (("z_mm", wheel.section.real), ("radius_mm", wheel.section.imag), ("nz", wheel.normal.real),
               ("nr", wheel.normal.imag), ("dresser_z_mm", wheel.dresser.real),
               ("dresser_radius_mm", wheel.dresser.imag))  # fmt: skip
    back = write_table(folder / FILENAME, [(name, values, 9) for name, values in columns])
    moved = np.abs(back[:, 0] + 1j * back[:, 1] - wheel.section)
    written = [
        WrittenFile(
            FILENAME, "csv", POINT_RESOLUTION, Deviation.of(wheel.section, moved), "numpy", {"points": len(back)}
        )
    ]
    if settings.template is not None:
        number = np.arange(1.0, wheel.section.size + 1.0)
        values: dict[str, FloatArray] = {"n": number, "x": wheel.dresser.imag, "z": wheel.dresser.real}
        lines = template_lines(settings.template, values, "export.form_wheel.template")
        (folder / _TEMPLATE_FILENAME).write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")
        written.append(WrittenFile(_TEMPLATE_FILENAME, "csv", None, None, None, {"points": len(lines)}))
    return tuple(written)


def read_form_wheel(path: Path) -> ComplexArray:
    """Section z + iρ of a wheel, shape (points,) [mm]."""
    table = read_table(path)
    return np.asarray(table[:, 0] + 1j * table[:, 1], dtype=np.complex128)
