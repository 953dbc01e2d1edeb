"""B-splines of certified deviation through a tooth, one flank at a time (docs/exports.md).

Nodes are spaced by |dP/dψ|^0.6, which gave far smaller deviations than equal phase or equal arc. The end derivatives
of each piece are those of the curve, so that neighbouring pieces join smoothly wherever the curve is smooth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.export.curves.audit import distances
from cycloid_profile.export.curves.curve_pieces import (
    Piece,
    ProfileSource,
    flanks,
    kept_for_its_profile,
    tolerance_error,
)
from cycloid_profile.geometry import ToothPoints, ToothProfile

FIT_SHARE = 0.8  # of the promised tolerance, used by the fit
_SPACING_EXPONENT = 0.6  # nodes by |P'|^0.6: between equal phase (0) and equal arc (1), for the fewest spans
_FINE = 4096  # table over a smooth piece
_CHECKS_PER_SPAN = 7  # inside a span; its ends lie on the curve
_DECIMALS = 9  # of coordinates [mm]: rounding of 1e-6 µm
# Spans of a piece: first trial, growth from trial to trial, and the limit of a tolerance that cannot be kept.
_FIRST_COUNT, _GROWTH, _LARGEST_COUNT = 8, 1.12, 2000


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class SplinePiece(Described):
    """A clamped B-spline over one flank, or over the whole disc.

    ``knots`` with full multiplicity at both ends; ``control_points`` complex, shape (n,) [mm].
    """

    degree: int
    knots: FloatArray
    control_points: ComplexArray

    def _key_figures(self) -> dict[str, str]:
        sizes = {"control points": f"{self.control_points.size}", "spans": f"{np.unique(self.knots).size - 1}"}
        return {"degree": f"{self.degree}"} | sizes

    def at(self, parameter: FloatArray) -> ComplexArray:
        """Points of the spline, complex, in the shape of ``parameter`` [mm]."""
        from scipy.interpolate import BSpline

        xy = np.stack([self.control_points.real, self.control_points.imag], axis=-1)
        points = BSpline(self.knots, xy, self.degree)(parameter)
        return np.asarray(points[..., 0] + 1j * points[..., 1], dtype=np.complex128)

    def beziers(self) -> ComplexArray:
        """The knot spans of a cubic as exact Bézier curves: control points, shape (spans, 4) [mm]."""
        from scipy.interpolate import BSpline

        curve = BSpline(self.knots, np.stack([self.control_points.real, self.control_points.imag], axis=-1), 3)
        edges = np.unique(self.knots)
        points, rates = curve(edges), curve.derivative()(edges)
        third = np.diff(edges)[:, np.newaxis] / 3.0
        ends = (points[:-1], points[:-1] + third * rates[:-1], points[1:] - third * rates[1:], points[1:])
        xy = np.stack(ends, axis=1)
        return np.asarray(xy[..., 0] + 1j * xy[..., 1], dtype=np.complex128)

    def dense(self) -> ComplexArray:
        """Points equally spaced inside every knot span, shape (spans·7,) [mm]."""
        edges = np.unique(self.knots)
        inner = (np.arange(_CHECKS_PER_SPAN) + 0.5) / _CHECKS_PER_SPAN
        return self.at((edges[:-1, np.newaxis] + np.diff(edges)[:, np.newaxis] * inner).ravel())

    def rotated(self, angle: float) -> SplinePiece:
        """The piece rotated about the disc's centre by ``angle`` [rad]."""
        return SplinePiece(self.degree, self.knots, self.control_points * np.exp(1j * angle))

    def rounded(self) -> SplinePiece:
        """Control points rounded to the picometre, so that files do not depend on the processor's last bit."""
        # Adding zero turns −0.0 into 0.0.
        control = np.asarray(np.round(self.control_points, _DECIMALS) + 0.0, dtype=np.complex128)
        return SplinePiece(self.degree, self.knots, control)


def lobe_splines(profile: ToothProfile, degree: int, tolerance: float) -> tuple[SplinePiece, ...]:
    """Splines of the two flanks of one lobe in order of phase, each within ``tolerance`` of the exact curve [mm].

    Raises ``ExportError`` if the tolerance takes more than 2000 nodes per flank.
    """
    return tuple(_fit(piece, degree, tolerance) for piece in flanks(profile) if piece.lobe == 0)


@kept_for_its_profile
def disc_splines(profile: ToothProfile, degree: int, tolerance: float) -> tuple[SplinePiece, ...]:
    """Splines of all flanks of the disc in order of phase, within ``tolerance`` [mm]; see ``lobe_splines``.

    The curve is divided at every tip and root: CAD kernels integrate long splines inaccurately. Each piece starts
    exactly at the last control point of the one before.
    """
    if not profile.identical_lobes:
        return _chained(_lobe_by_lobe(profile, degree, tolerance))
    lobe = lobe_splines(profile, degree, tolerance)
    lobes = profile.trochoid.lobes
    return _chained(tuple(piece.rotated(-2.0 * math.pi * m / lobes).rounded() for m in range(lobes) for piece in lobe))


def fitted_splines(source: ProfileSource, degree: int) -> tuple[SplinePiece, ...]:
    """``disc_splines`` of a disc to be made, within the share of its tolerance that is left to the fit."""
    return disc_splines(source.profile, degree, FIT_SHARE * source.spec.export.chord_tolerance)


def joined(pieces: tuple[SplinePiece, ...]) -> SplinePiece:
    """One closed spline of consecutive ``pieces``, with full interior multiplicity at the joints."""
    degree = pieces[0].degree
    knots: list[FloatArray] = [np.zeros(degree + 1)]
    points: list[ComplexArray] = [pieces[0].control_points[:1]]
    start = 0.0
    for piece in pieces:
        points.append(piece.control_points[1:])
        inner = piece.knots[degree + 1 : -(degree + 1)]
        end = start + piece.knots[-1]
        knots += [start + inner, np.full(degree, end)]
        start = end
    knots.append(np.array([start]))
    control = np.concatenate(points)
    rounded = np.asarray(np.round(np.concatenate(knots), _DECIMALS), dtype=np.float64)
    return SplinePiece(degree, rounded, control)


def _chained(pieces: tuple[SplinePiece, ...]) -> tuple[SplinePiece, ...]:
    """The closed chain of ``pieces`` with bitwise equal end points, which rounding can set apart by its unit."""
    ends = [piece.control_points[-1:] for piece in pieces]
    return tuple(
        replace(piece, control_points=np.concatenate([end, piece.control_points[1:]]))
        for piece, end in zip(pieces, [ends[-1], *ends[:-1]], strict=True)
    )


def _lobe_by_lobe(profile: ToothProfile, degree: int, tolerance: float) -> tuple[SplinePiece, ...]:
    """Splines of every lobe; the number of nodes of lobe 1 is tried first, because lobes differ little in curvature."""
    counts = [len(np.unique(piece.knots)) - 1 for piece in lobe_splines(profile, degree, tolerance)]
    fitted = []
    for i, piece in enumerate(flanks(profile)):
        curve = _interpolate(piece, degree, counts[i % len(counts)])
        fitted.append((curve if _error(curve, profile) <= tolerance else _fit(piece, degree, tolerance)).rounded())
    return tuple(fitted)


def _error(curve: SplinePiece, profile: ToothProfile) -> float:
    return float(np.max(np.abs(distances(profile, curve.dense()))))


def _fit(piece: Piece, degree: int, tolerance: float) -> SplinePiece:
    """The first spline, with a growing number of nodes, whose measured error is within ``tolerance`` [mm]."""
    count = _FIRST_COUNT
    while count <= _LARGEST_COUNT:
        curve = _interpolate(piece, degree, count)
        if _error(curve, piece.profile) <= tolerance:
            return curve
        count = math.ceil(_GROWTH * count)
    raise tolerance_error(tolerance, f"{_LARGEST_COUNT} nodes per piece")


def _interpolate(piece: Piece, degree: int, count: int) -> SplinePiece:
    from scipy.interpolate import make_interp_spline

    u, psi = _nodes(piece, count)
    nodes = piece.profile.at(psi, piece.side(psi))
    ends = _end_derivatives(nodes)
    wanted = range(1, (degree - 1) // 2 + 1)
    conditions = tuple([(order, _xy(ends[order - 1][end])) for order in wanted] for end in (0, -1))
    spline = make_interp_spline(u, _xy(nodes.position), k=degree, bc_type=conditions)
    return SplinePiece(degree, np.asarray(spline.t), np.asarray(spline.c[:, 0] + 1j * spline.c[:, 1]))


def _nodes(piece: Piece, count: int) -> tuple[FloatArray, FloatArray]:
    """Parameters u = ∫|P'|^0.6 dψ, equally spaced, and their phases."""
    from scipy.interpolate import CubicSpline

    grid, side = piece.grid(_FINE)
    density = CubicSpline(grid, np.abs(piece.profile.at(grid, side).first) ** _SPACING_EXPONENT)
    integral = density.antiderivative()
    u = np.round(np.linspace(0.0, float(integral(piece.b)), count + 1), _DECIMALS)
    psi = np.interp(u, integral(grid), grid)
    for _ in range(3):
        # Newton: a rough ψ(u) would cost a quintic its order.
        psi = psi - (integral(psi) - u) / density(psi)
    psi[0], psi[-1] = piece.a, piece.b
    return u, psi


def _end_derivatives(nodes: ToothPoints) -> tuple[ComplexArray, ComplexArray]:
    """First and second derivatives by the spline's parameter u, where du/dψ = |P'|^0.6."""
    speed = np.abs(nodes.first)
    psi_u = speed**-_SPACING_EXPONENT
    speed_change = (np.conj(nodes.first) * nodes.second).real / speed
    psi_uu = -_SPACING_EXPONENT * speed ** (-2.0 * _SPACING_EXPONENT - 1.0) * speed_change
    return nodes.first * psi_u, nodes.second * psi_u**2 + nodes.first * psi_uu


def _xy(z: ComplexArray) -> FloatArray:
    return np.stack([z.real, z.imag], axis=-1)
