"""Enlarged detail of one tooth with its radii, and a graph of the removal along it."""

from __future__ import annotations

import cmath
import math

import numpy as np

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.design import DesignRecord
from cycloid_profile.export.curves import distances
from cycloid_profile.export.drawing._sheet import SMALL, TEXT, Sheet, polar
from cycloid_profile.export.drawing._symbols import Frame, Roughness, Row, Words, dimension, label
from cycloid_profile.export.drawing._tolerances import Tolerances
from cycloid_profile.export.inspection import OF_TEETH
from cycloid_profile.geometry import ToothProfile, least_radii, over_rollers
from cycloid_profile.units import UM

_BEYOND = 0.1 * math.pi  # phase shown beyond the roots
_POINTS = 1201  # chords of the enlarged tooth are invisible on paper
_WIDEST, _HIGHEST = 146.0, 30.0
_PIN_SHOWN, _PIN_WIDTH = 60.0, 12.0  # ° on either side of its lowest point, but no wider, mm
_GRAPH, _HEADROOM = 46 + 34j, 1.15


def detail_scale(record: DesignRecord, scales: tuple[float, ...]) -> float:
    """The largest scale at which the tooth fits its space [mm of paper per mm]; the smallest if none fits."""
    tooth = _upright_lobe(record.profile, 0j, 1.0)
    width, height = np.ptp(tooth.real), np.ptp(tooth.imag)
    fitting = [scale for scale in scales if scale * width <= _WIDEST and scale * height <= _HIGHEST]
    return max(fitting, default=min(scales))


def draw_detail(sheet: Sheet, record: DesignRecord, limits: Tolerances, at: complex, scale: float, shown: str) -> None:
    """The tooth between two roots, ``at`` the root level below its tip [mm of paper]."""
    profile, outline = record.profile, record.outline
    lobes, root, tip = profile.trochoid.lobes, outline.root_radius, outline.tip_radius
    tooth = _upright_lobe(profile, at, scale)
    sheet.polyline([complex(p) for p in tooth], "PROFILE")
    hub = at - 1j * root * scale
    half = math.pi / lobes
    left_root, right_root = (hub + root * scale * cmath.rect(1.0, 0.5 * math.pi + side * half) for side in (1, -1))
    open_deg = math.degrees(half) * 1.3
    for radius, layer in ((root, "THIN"), (tip, "CENTRE")):
        sheet.arc(hub, radius * scale, 90.0 - open_deg, 90.0 + open_deg, layer)
    pin_end = _pin(sheet, record, left_root, hub, scale)
    for end in (left_root, right_root):
        along = (hub - end) / abs(hub - end)
        sheet.line(end - 4.0 * along, end + 4.0 * along, "CENTRE")
    chord = 2.0 * root * math.sin(half)
    below = float(min(np.min(tooth.imag), left_root.imag)) - 22.0
    sheet.text(complex(at.real, below), f"Z ({shown})", 3.5, "CENTER")
    dimension(sheet, left_root, right_root, -1j, f"{chord:.3f}")
    # At the right ends of both arcs, which the extension lines continue.
    radial = polar(1.0, 90.0 - open_deg)
    dimension(sheet, hub + root * scale * radial, hub + tip * scale * radial, -1j * radial, f"{tip - root:.3f}")
    _labels(sheet, record, limits, at, scale, hub)
    label(sheet, pin_end, [Words(f"pin Ø{2.0 * record.drive.pin_radius:g}")])


def _labels(
    sheet: Sheet, record: DesignRecord, limits: Tolerances, at: complex, scale: float, hub: complex
) -> None:  # fmt: skip
    """Tip and root radius, least radii of curvature, pitch, tolerances and roughness of the flank."""
    outline, least, lobes = record.outline, least_radii(record.profile), record.profile.trochoid.lobes
    half = math.pi / lobes
    psi = np.linspace(0.0, math.pi, _POINTS)
    kappa = record.profile.at(psi, np.ones_like(psi)).curvature
    # The flank of rising phase is on the left; the equivalent points of the right one are marked.
    right = _on_paper(record.profile, 2.0 * math.pi - psi, at, scale)
    left = _on_paper(record.profile, psi, at, scale)
    tip_at = hub + outline.tip_radius * scale * cmath.rect(1.0, 0.5 * math.pi - 0.25 * half)
    root_at = hub + outline.root_radius * scale * cmath.rect(1.0, 0.5 * math.pi - 1.2 * half)
    found: list[tuple[complex, list[Row]]] = [
        (tip_at, [Words(f"R{outline.tip_radius:.3f} tip")]),
        (complex(right[int(np.argmin(kappa))]), [Words(f"least convex R{least.convex:.3f}")]),
        (root_at, [Words(f"R{outline.root_radius:.3f} root"), Frame((f"{lobes} × {360.0 / lobes:.6g}°",))]),
    ]
    if math.isfinite(least.concave):
        found.append((complex(right[int(np.argmax(kappa))]), [Words(f"least concave R{least.concave:.3f}")]))
    for tip, rows in found:
        label(sheet, tip, rows)
    flank = complex(left[int(0.55 * _POINTS)])
    label(sheet, flank, [
        # One zone for all flanks, whose pitch it holds; their common turn about the axis is free.
        Frame(("profile", limits.profile.in_unit(" CZ"), *OF_TEETH), f"{lobes} ×"),
        Frame(("runout", f"{limits.runout}", *OF_TEETH), "roots"),
        Roughness(record.spec.export.drawing.tooth_roughness_ra_um),
    ])  # fmt: skip


def _pin(sheet: Sheet, record: DesignRecord, root: complex, hub: complex, scale: float) -> complex:
    """The lower part of the pin in the left root; returns its left end."""
    radius = record.drive.pin_radius
    out = (root - hub) / abs(root - hub)
    centre = hub + out * over_rollers(record.profile, radius).centre_radius * scale
    lowest = math.degrees(cmath.phase(-out))
    shown = min(_PIN_SHOWN, math.degrees(math.asin(min(1.0, _PIN_WIDTH / (radius * scale)))))
    sheet.arc(centre, radius * scale, lowest - shown, lowest + shown, "PINS")
    return centre + radius * scale * polar(1.0, lowest - shown)


def _upright_lobe(profile: ToothProfile, at: complex, scale: float) -> ComplexArray:
    return _on_paper(profile, np.linspace(-_BEYOND, 2.0 * math.pi + _BEYOND, _POINTS), at, scale)


def _on_paper(profile: ToothProfile, psi: np.ndarray, at: complex, scale: float) -> ComplexArray:
    """Points of lobe 1 with its tip upwards; ``at`` is on the root circle below the tip [mm of paper]."""
    root = float(np.abs(profile.at(0.0).position))
    upright = cmath.rect(1.0, 0.5 * math.pi + math.pi / profile.trochoid.lobes)
    return at + scale * (profile.at(psi).position * upright - 1j * root)


def draw_removal(sheet: Sheet, record: DesignRecord, corner: complex) -> None:
    """Graph of the removal along the normal of the theoretical tooth from root to tip; ``corner`` is its lower left."""
    psi = np.linspace(0.0, math.pi, 181)
    points = record.profile.at(psi, np.ones_like(psi)).position
    # Rounded to the picometre, so that an unmodified tooth gives zero.
    removed = np.round(-distances(record.drive.theoretical_profile, points) / UM, 6) + 0.0
    low, high = min(0.0, float(np.min(removed))), max(0.0, float(np.max(removed)))
    span = _HEADROOM * max(high - low, 1e-3)
    width, height = _GRAPH.real, _GRAPH.imag

    def place(phase: float, value: float) -> complex:
        return corner + complex(width * phase / math.pi, height * (value - low) / span)

    sheet.box(corner, _GRAPH)
    sheet.line(place(0.0, 0.0), place(math.pi, 0.0), "THIN")
    sheet.polyline([place(float(a), float(v)) for a, v in zip(psi, removed, strict=True)], "PROFILE")
    for i, name in enumerate(("0° root", "45°", "90°", "135°", "180° tip")):
        at = place(math.pi * i / 4, low)
        sheet.line(at, at + 1.5j)
        sheet.text(at - 4.2j, name, SMALL, "CENTER")
        sheet.text(at - 7.4j, f"{removed[45 * i] + 0.0:.2f}", SMALL, "CENTER")
    for value in sorted({low, 0.0, high}):
        sheet.line(place(0.0, value), place(0.0, value) + 1.5)
        sheet.text(place(0.0, value) - 1.0 - 0.5j * SMALL, f"{value:.3g}", SMALL, "RIGHT")
    sheet.text(corner + 0.5 * width + 1j * (height + 1.6), "removal along the normal [µm]", TEXT, "CENTER")
    sheet.text(corner + 0.5 * width - 10.8j, "over phase ψ; values below", SMALL, "CENTER")
