"""The grinding wheel against the tooth: admissible radius, distance to the tooth, stock left in grooves."""

from __future__ import annotations

import math

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.contact.mesh import nearest_foot
from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves import flanks, pieces
from cycloid_profile.geometry import ToothProfile, least_radii

_GRID = 721  # phases on a smooth part where lobes differ
_SAMPLES_PER_LOBE = 360  # one a degree of phase
# Of the least concave radius: leaves room at the grooves of a compensated tooth at root and tip.
DEFAULT_SHARE = 0.8
# Of the root radius, for teeth without a concave part, which any wheel fits.
LARGEST_SHARE = 0.5


def least_concave_radius(profile: ToothProfile) -> float:
    """Least radius of the concave parts of all lobes [mm], infinite where there is none."""
    if profile.identical_lobes:
        return least_radii(profile).concave
    tightest = 0.0
    for piece in pieces(profile):
        psi, side = piece.grid(_GRID)
        tightest = max(tightest, float(np.max(profile.at(psi, side).curvature)))
    return 1.0 / tightest if tightest > 0.0 else math.inf


def wheel_radius(profile: ToothProfile, asked_mm: float | None) -> float:
    """The radius ``asked_mm``, or by default one that fits every root, to two digits [mm].

    Raises ``ExportError`` if a wheel of that radius would gouge the flanks at a root.
    """
    limit = least_concave_radius(profile)
    if asked_mm is None:
        room = min(DEFAULT_SHARE * limit, LARGEST_SHARE * float(np.abs(profile.at(0.0).position)))
        digit = 10.0 ** (math.floor(math.log10(room)) - 1)
        return round(math.floor(room / digit) * digit, 9)
    if asked_mm >= limit:
        raise ExportError(
            "export.wheel_radius_mm",
            f"{asked_mm:g}",
            f"is not below the least concave radius of the tooth, {limit:.4f} mm, and would gouge it",
            "take a smaller wheel",
        )
    return asked_mm


def clearance(profile: ToothProfile, centre: ComplexArray) -> FloatArray:
    """Distance of points outside the disc from the tooth curve [mm], in the shape of ``centre``; the foot points are
    exact."""
    lobes, period = profile.trochoid.lobes, profile.trochoid.phase_period
    phase = np.linspace(0.0, period, lobes * _SAMPLES_PER_LOBE, endpoint=False)
    nearest = phase[_nearest_of(profile.at(phase).position, centre)]
    # In the frame of the nearest lobe, root at phase 0.
    lobe = np.round(nearest / (2.0 * math.pi))
    in_lobe = centre * np.exp(2j * math.pi * lobe / lobes)
    which = None if profile.identical_lobes else np.mod(lobe, lobes)
    foot, side = nearest_foot(profile, in_lobe, nearest - 2.0 * math.pi * lobe, which)
    found: FloatArray = np.abs(in_lobe - profile.at(foot, side, which).position)
    return found


def groove_stock(profile: ToothProfile, centre: ComplexArray, radius: float) -> float:
    """Largest stock that a wheel at these centres leaves in the grooves between flanks [mm]."""
    if not profile.corners:
        return 0.0
    # Smooth roots and tips, which the wheel touches, add nothing.
    corners = np.array([complex(f.profile.at(f.a, f.side(np.array(f.a))).position) for f in flanks(profile)])
    away = np.abs(corners - centre[_nearest_of(centre, corners)])
    return max(0.0, float(np.max(away)) - radius)


def overlap_at_grooves(profile: ToothProfile, radius: float) -> float:
    """Largest gouge of a wheel that follows each flank to its end at a groove [mm].

    Applies to controls that do not trim their offset path at corners of a milliradian: with the corner angle τ of the
    tangent, τ²/(2(1/R − κ)).
    """
    parts = flanks(profile)
    count = len(parts) // profile.trochoid.lobes if profile.identical_lobes else len(parts)
    worst = 0.0
    for k in range(count):
        one, other = parts[k], parts[(k + 1) % len(parts)]
        before, after = (
            p.profile.at(np.array([at]), p.side(np.array([at]))) for p, at in ((one, one.b), (other, other.a))
        )
        turn = float(np.angle(after.first[0] / before.first[0]))
        curvature = max(float(before.curvature[0]), float(after.curvature[0]))
        if turn > 0.0:
            worst = max(worst, turn**2 / (2.0 * (1.0 / radius - curvature)))
    return worst


def _nearest_of(candidates: ComplexArray, points: ComplexArray) -> IntArray:
    """Index of the nearest candidate of each point, shape (points,)."""
    from scipy.spatial import cKDTree

    tree = cKDTree(np.stack([candidates.real, candidates.imag], axis=-1))
    index: IntArray = tree.query(np.stack([points.real, points.imag], axis=-1))[1]
    return index
