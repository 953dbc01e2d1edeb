"""B-splines of certified deviation through a tooth, one smooth piece at a time (docs/exports.md).

Nodes are spaced by |dP/dψ|^0.6, which measured far better than equal phase or equal arc; the end
derivatives of each piece are the curve's own, so that neighbouring pieces join smoothly wherever the
curve itself is smooth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.export.deviation import distances
from cycloid_profile.export.disc_path import Piece, pieces
from cycloid_profile.export.refine import refined
from cycloid_profile.geometry.profile import ToothPoints, ToothProfile
from cycloid_profile.geometry.sampling import smooth_pieces

_SPACING_EXPONENT = 0.6
_FINE = 4096
_CHECKS_PER_SPAN = 7
_DECIMALS = 9


@dataclass(frozen=True, slots=True)
class SplinePiece:
    """A clamped B-spline over one smooth piece of a lobe.

    ``knots`` with full multiplicity at both ends; ``control_points`` complex, shape (n,) [mm].
    """

    degree: int
    knots: FloatArray
    control_points: ComplexArray

    def at(self, parameter: FloatArray) -> ComplexArray:
        """Points of the spline, complex, in the shape of ``parameter`` [mm]."""
        from scipy.interpolate import BSpline

        xy = np.stack([self.control_points.real, self.control_points.imag], axis=-1)
        points = BSpline(self.knots, xy, self.degree)(parameter)
        return np.asarray(points[..., 0] + 1j * points[..., 1], dtype=np.complex128)

    def dense(self) -> ComplexArray:
        """Points inside every knot span, for measuring."""
        return self.at(inside_spans(self.knots, _CHECKS_PER_SPAN))

    def turned(self, angle: float) -> SplinePiece:
        """The piece turned about the disc's centre by ``angle`` [rad]."""
        return SplinePiece(self.degree, self.knots, self.control_points * np.exp(1j * angle))

    def rounded(self) -> SplinePiece:
        """Control points to the picometre, so that the last bit of a processor's sine changes no file."""
        # Adding zero turns −0.0 into 0.0.
        control = np.asarray(np.round(self.control_points, _DECIMALS) + 0.0, dtype=np.complex128)
        return SplinePiece(self.degree, self.knots, control)


def inside_spans(knots: FloatArray, per_span: int) -> FloatArray:
    """Parameters evenly inside every knot span, ``per_span`` in each."""
    edges = np.unique(knots)
    inner = (np.arange(per_span) + 0.5) / per_span
    parameters: FloatArray = (edges[:-1, np.newaxis] + np.diff(edges)[:, np.newaxis] * inner).ravel()
    return parameters


def lobe_splines(profile: ToothProfile, degree: int, tolerance: float) -> tuple[SplinePiece, ...]:
    """Splines of one lobe in order of phase, each within ``tolerance`` of the exact curve [mm].

    Raises
    ------
    ExportError
        If the tolerance cannot be reached with a sensible number of control points.
    """
    return tuple(_fit(Piece(profile, 0, a, b), degree, tolerance) for a, b in smooth_pieces(profile))


def disc_splines(profile: ToothProfile, degree: int, tolerance: float) -> tuple[SplinePiece, ...]:
    """Splines of the whole disc in order of phase: those of one lobe, turned, or lobe by lobe where they differ."""
    if not profile.lobes_alike:
        return _lobe_by_lobe(profile, degree, tolerance)
    lobe = lobe_splines(profile, degree, tolerance)
    lobes = profile.trochoid.lobes
    return tuple(piece.turned(-2.0 * math.pi * m / lobes).rounded() for m in range(lobes) for piece in lobe)


def joined(pieces: tuple[SplinePiece, ...]) -> SplinePiece:
    """One closed spline: pieces end to end, full interior multiplicity at the joints."""
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
    control[-1] = control[0]
    rounded = np.asarray(np.round(np.concatenate(knots), _DECIMALS), dtype=np.float64)
    return SplinePiece(degree, rounded, control)


def _lobe_by_lobe(profile: ToothProfile, degree: int, tolerance: float) -> tuple[SplinePiece, ...]:
    """Each piece is first tried with as many nodes as on lobe 1: lobes differ little in their bending."""
    counts = [len(np.unique(piece.knots)) - 1 for piece in lobe_splines(profile, degree, tolerance)]
    fitted = []
    for i, piece in enumerate(pieces(profile)):
        curve = _interpolate(piece, degree, counts[i % len(counts)])
        kept = float(np.max(np.abs(distances(profile, curve.dense())))) <= tolerance
        fitted.append((curve if kept else _fit(piece, degree, tolerance)).rounded())
    return tuple(fitted)


def _fit(piece: Piece, degree: int, tolerance: float) -> SplinePiece:
    return refined(piece.profile, tolerance, lambda count: _interpolate(piece, degree, count), SplinePiece.dense)


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
