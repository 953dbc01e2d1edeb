"""Any drive from 3 to 300 lobes: its outline is valid or refused with the limit, and rolls among its pins.

The disc is rolled by its kinematics alone, as a polygon made of the splines that are exported: centre on the
eccentric, rotated back by φ/z_c. Every pin of every pose is transformed to its lobe and the two neighbouring lobes.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from cycloid_profile.contact.mesh import first_touch, mesh
from cycloid_profile.errors import GeometryError
from cycloid_profile.export.curves import SplinePiece, deviation_both_ways, disc_splines
from cycloid_profile.geometry import CentralEccentric, Drive, ToothProfile, Trochoid, undercut_limit
from cycloid_profile.modification import Equidistant, modify

TOLERANCE = 5e-5  # mm, of the splines
CHORDS = 2e-5  # mm, of the polygon
PIN_POSITIONS = 8000  # pin positions: every pin of as many poses as needed
RADIUS = 64.0


def rows(pieces: tuple[SplinePiece, ...], per_span: int) -> np.ndarray:
    """Points along every knot span, shape (spans, points)."""
    spans = []
    for piece in pieces:
        edges = np.unique(piece.knots)
        share = np.linspace(0.0, 1.0, per_span)
        spans.append(piece.at(edges[:-1, None] + np.diff(edges)[:, None] * share))
    return np.concatenate(spans)


def crank_angles(trochoid: Trochoid) -> np.ndarray:
    """Evenly spread over a turn, shape (poses,) [rad]."""
    poses = max(PIN_POSITIONS // trochoid.pins, 24)
    return 2.0 * math.pi * np.arange(poses) / poses


def rolled_gaps(
    pieces: tuple[SplinePiece, ...], profile: ToothProfile, drive: Drive, turn: np.ndarray | float = 0.0
) -> np.ndarray:
    """Distance of every pin from the disc's polygon at evenly spread crank angles, shape (poses, pins) [mm]."""
    trochoid = drive.trochoid
    z_c, z_p = trochoid.lobes, trochoid.pins
    phi = crank_angles(trochoid)[:, None]
    pins = trochoid.pin_circle_radius * np.exp(2j * math.pi * np.arange(z_p) / z_p)
    seen = (pins - trochoid.eccentricity * np.exp(1j * phi)) * np.exp(1j * (phi / z_c - np.reshape(turn, (-1, 1))))
    seen = seen * np.exp(2j * math.pi * np.round(-np.angle(seen) * z_c / (2.0 * math.pi)) / z_c)
    each = len(pieces) // z_c
    near = [piece.rotated(2.0 * math.pi * k / z_c) for k in (1, 0, -1) for piece in pieces[:each]]
    # As many chords as keep their sagitta κs²/8 within CHORDS.
    curvature = float(np.max(np.abs(profile.at(np.linspace(0.0, 2.0 * math.pi, 4001)).curvature)))
    longest = float(np.max(np.sum(np.abs(np.diff(rows(tuple(near), 9))), axis=1)))
    line = rows(tuple(near), math.ceil(longest * math.sqrt(curvature / (8.0 * CHORDS))) + 1).ravel()
    curve = shapely.LineString(np.stack([line.real, line.imag], axis=-1))
    shapely.prepare(curve)
    off = shapely.distance(curve, shapely.points(np.stack([seen.real, seen.imag], axis=-1)))
    return off - drive.pin_radius


@st.composite
def drives(draw: st.DrawFn, most: int) -> tuple[Trochoid, float, float]:
    """A trochoid, a pin radius and the least radius that must be refused."""
    lobes = draw(st.integers(3, most))
    trochoid = Trochoid(lobes + 1, RADIUS, draw(st.floats(0.1, 0.95)) * RADIUS / (lobes + 1))
    limit = min(undercut_limit(trochoid), RADIUS * math.sin(math.pi / (lobes + 1)))
    return trochoid, draw(st.floats(0.05, 1.1)) * limit, limit


def check(trochoid: Trochoid, radius: float, limit: float) -> None:
    if radius >= limit:
        with pytest.raises(GeometryError, match=f"limit (is )?{limit:.4f} mm"):
            Drive(trochoid, radius, 10.0, 1, CentralEccentric(1e5))
        return
    drive = Drive(trochoid, radius, 10.0, 1, CentralEccentric(1e5))
    pieces = disc_splines(drive.theoretical_profile, 5, TOLERANCE)
    both = deviation_both_ways(drive.theoretical_profile, rows(pieces, 9))
    assert both.largest <= TOLERANCE
    assert both.from_curve is not None
    assert both.from_curve <= TOLERANCE
    outline = rows(pieces, 5)[:, :-1].ravel()
    assert shapely.Polygon(np.stack([outline.real, outline.imag], axis=-1)).is_valid
    # A perfect tooth touches every pin at every pose.
    gaps = rolled_gaps(pieces, drive.theoretical_profile, drive)
    assert np.min(gaps) >= -(TOLERANCE + CHORDS)
    assert np.max(gaps) <= TOLERANCE + CHORDS


@settings(deadline=None, max_examples=3)
@given(drive=drives(60))
def test_a_drive_is_refused_or_rolls(drive: tuple[Trochoid, float, float]) -> None:
    check(*drive)


@pytest.mark.slow
@settings(deadline=None, max_examples=60)
@given(drive=drives(300))
def test_any_drive_is_refused_or_rolls(drive: tuple[Trochoid, float, float]) -> None:
    check(*drive)


def test_a_disc_with_play_touches_where_the_engine_says() -> None:
    drive = Drive(Trochoid(40, RADIUS, 1.3), 3.0, 10.0, 1, CentralEccentric(1e5))
    profile = modify(ToothProfile(drive.trochoid, 3.0), Equidistant(0.010))
    pieces = disc_splines(profile, 5, TOLERANCE)
    phi = crank_angles(drive.trochoid)
    for direction in (1.0, -1.0):
        touch = first_touch(profile, drive.pin_radius, mesh(drive.trochoid, phi), direction)
        gaps = rolled_gaps(pieces, profile, drive, touch.rotation[:, 0])
        assert np.all(np.abs(np.min(gaps, axis=1)) <= TOLERANCE + CHORDS)
        assert np.allclose(gaps, touch.gaps.gap[:, 0], atol=TOLERANCE + CHORDS)
        # The pin that touches is the engine's, or one that it has as near.
        first = np.argmin(gaps, axis=1)
        assert np.all(touch.gaps.gap[np.arange(phi.size), 0, first] <= 2.0 * (TOLERANCE + CHORDS))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lobes", "ratio", "fill"), [(3, 0.95, 0.9), (3, 0.1, 0.99), (120, 0.9, 0.95), (300, 0.1, 0.9)]
)
def test_step_of_extreme_drives_is_sound(lobes: int, ratio: float, fill: float, tmp_path: Path) -> None:
    pytest.importorskip("OCP", reason="the CAD kernel is not installed")
    from cycloid_profile.export.cad import CadMaterial, CadPart
    from cycloid_profile.export.cad._solids import (
        plate,
        points_on,
        read_shape,
        sound_solids,
        top_edges,
        write_part,
    )

    trochoid = Trochoid(lobes + 1, RADIUS, ratio * RADIUS / (lobes + 1))
    limit = min(undercut_limit(trochoid), RADIUS * math.sin(math.pi / (lobes + 1)))
    profile = ToothProfile(trochoid, fill * limit)
    solid = plate(disc_splines(profile, 5, 0.8 * TOLERANCE), (), 0.0, 10.0)
    path = tmp_path / "disc.step"
    write_part(CadPart("disc", solid, (0.5, 0.5, 0.5), CadMaterial("steel", "")), path, "AP242")
    (back,) = sound_solids(read_shape(path), path, 1)
    found = deviation_both_ways(profile, points_on(top_edges(back)[0]))
    assert found.largest <= TOLERANCE
    assert found.from_curve is not None
    assert found.from_curve <= TOLERANCE
