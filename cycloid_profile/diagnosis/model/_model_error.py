"""Error of the model, as nuisances with prior widths (docs/diagnosis.md, "Error of the model").

Reasonable models of one reducer differ: in contact law, in the elasticity of disc and bearings, and in the form of an
effect. These differences grow with the load and with the effect, so that they have no constant size.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from cycloid_profile.contact.bodies import DiscCompliance
from cycloid_profile.contact.stage import LoadedContacts
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.data._loops import (
    FRICTION_MARGIN,
    NEAR_ZERO,
    load_direction,
    path_error_share,
    torque_since_reversal,
)
from cycloid_profile.diagnosis.data._smooth_forms import (
    CORNER_MULTIPLES,
    distinct_waves,
    forms_of_scan,
    hat_functions,
    waves,
)
from cycloid_profile.diagnosis.data.noise import Noise
from cycloid_profile.diagnosis.data.recording import Recording
from cycloid_profile.diagnosis.model.priors import body_error
from cycloid_profile.effects import AsBuiltReducer, loop_branches
from cycloid_profile.errors import CycloidError
from cycloid_profile.geometry import Trochoid
from cycloid_profile.measurement import HYSTERESIS, PROFILE_SCAN
from cycloid_profile.rig import LinearisedCurve
from cycloid_profile.units import NEWTON_METRE

_NEAR, _FAR = 1.0, 4.0  # pin pitches over which the coupling of neighbouring pins by the disc decays
_STICKS = (0.5, 1.5)  # of the torque over which friction sticks after a reversal: others slip sooner or later
_OCTAVES = 6  # of torque: below a thirtieth of the largest either flank may touch
_LEAST_FRICTION = 1e-6  # of the largest torque: it sticks over less than the step between any two rows
_TORQUE_STEP = 0.1  # of the largest torque: about one further pin bears
_SHARED = 0.3  # of the largest singular value of waves: those of two that hardly differ are below
_ROWS_OF_MULTIPLE = 16  # for each of them, twice as many as its columns and those of the other orders
_FALLING = 3  # of lobes times pins, to which bodies, and effects that are the same at all angles, leave a ripple
_MULTIPLES = 6  # of lobes and pins: amplitudes fall with the harmonic


def load_error(reducer: AsBuiltReducer, curve: LinearisedCurve) -> FloatArray:
    """Columns of the error that grows with the load, in the unit of the file, shape (rows, columns).

    Contact law (its factor and its exponent), coupling of neighbouring pins by the disc, and bearings, each with the
    width in ``_tuned``.
    """
    law, contact = reducer.case.law, reducer.case.line_contact

    def approach(at: LoadedContacts) -> FloatArray:
        return law.approach(at.force, contact(at.curvature))

    def exponent(at: LoadedContacts) -> FloatArray:
        return approach(at) * np.log(at.force / np.mean(at.force))

    def coupling(pitches: float) -> FloatArray:
        return curve.opened(lambda at: _coupled(at, reducer, pitches) * float(np.mean(approach(at))))

    body = body_error(reducer)
    columns = [
        tuned.CONTACT_LAW * curve.opened(approach),
        tuned.CONTACT_LAW * curve.opened(exponent),
        body * coupling(_NEAR),
        body * coupling(_FAR),
    ]
    softer = tuned.BEARING_STIFFNESS / reducer.case.drive.support.bearing_stiffness
    bearings = np.zeros_like(columns[0])
    with suppress(CycloidError):
        bearings = curve.change(reducer.with_bearings(softer=softer))
    return _finite(np.stack([*columns, bearings], axis=1))


def uneven_discs(reducer: AsBuiltReducer, curve: LinearisedCurve) -> FloatArray:
    """The column of elastic discs that are softer in some directions, shape (rows, 1); none for rigid discs."""
    return _softened(tuple(one.uneven_part for one in reducer.case.disc_bodies), curve)


def hole_error(reducer: AsBuiltReducer, curve: LinearisedCurve) -> FloatArray:
    """The column of elastic discs that give way at the bearing holes, shape (rows, 1); none for rigid discs.

    Forces on the holes bend the disc as its flanks do, and more where one crank carries more than the others.
    """
    return _softened(tuple(one.hole_part for one in reducer.case.disc_bodies), curve)


def _softened(by: tuple[DiscCompliance, ...], curve: LinearisedCurve) -> FloatArray:
    if not by:
        return np.zeros((curve.prediction.rows.size, 0))
    return _finite(tuned.HOLES * curve.softened(by)[:, np.newaxis])


def pins_error(curve: LinearisedCurve, recording: Recording, linear: FloatArray) -> FloatArray:
    """Columns of the error of a loop where further pins come to bear, hat functions of torque, shape (rows, columns).

    Models differ in the torque at which each pin does: their twist differs by a corner there, which the ``linear``
    errors, shape (rows, errors), do not have. The width is a share of the root of their sum of squares.
    """
    if recording.kind is not HYSTERESIS:
        return np.zeros((recording.rows.size, 0))
    through = np.nan_to_num(curve.prediction.terms[0].through)
    step = _TORQUE_STEP * float(np.max(np.abs(through)))
    hats = hat_functions((through - np.min(through)) / step, int(np.ceil(np.ptp(through) / step)) + 1)
    width: FloatArray = tuned.PINS * np.linalg.norm(linear, axis=1)
    return width[:, np.newaxis] * hats


@dataclass(frozen=True, eq=False)
class CornerWaves:
    """Waves of a turn that show where further pins come to bear: multiples of lobes, and of pins.

    An effect on pins repeats with each lobe, one on lobes with each pin. Where a pin comes to bear the twist has a
    corner, which all multiples show equally. ``wave``: shape (rows, orders); ``family`` of each order: 0 other orders,
    1 multiples of lobes, 2 multiples of pins. ``inverse``: shape (2·orders, rows), gives cosines, then sines.
    """

    wave: ComplexArray
    family: IntArray
    inverse: FloatArray

    @classmethod
    def of(cls, reducer: AsBuiltReducer, position: FloatArray) -> CornerWaves:
        """The waves at the rows of a turn."""
        trochoid = reducer.case.drive.trochoid
        counts = np.array([trochoid.lobes, trochoid.pins])
        k = np.arange(1, min(CORNER_MULTIPLES, position.size // _ROWS_OF_MULTIPLE) + 1)
        # Forms of parts and the ripple of equal lobes and pins err by themselves. On few rows they look like others.
        others = np.concatenate([np.arange(tuned.LOW_ORDERS + 1), low_product_orders(trochoid)])
        corners = [count * k[count * k % np.prod(counts) > 0] for count in counts]
        wave = np.exp(1j * np.outer(position, np.concatenate([others, *corners])))
        family = np.repeat([0, 1, 2], [others.size, *(one.size for one in corners)])
        distinct = distinct_waves(wave)
        wave, family = wave[:, distinct], family[distinct]
        # Rows at nearly equal distances show some orders nearly as others: these share what is seen.
        return cls(wave, family, np.linalg.pinv(np.hstack([wave.real, wave.imag]), rcond=_SHARED))

    def error(self, added: FloatArray, noise: Noise) -> FloatArray:
        """Columns of the error, shape (rows, columns), from what effects have ``added`` to the linear errors.

        ``added``: shape (rows, errors). The width at a multiple is a share of all of it at those of lobes, or of pins,
        and at most what is added at this one.
        """
        amounts = (self.inverse @ added).reshape(2, self.family.size, -1)
        ripple = np.linalg.norm(amounts, axis=(0, 2))
        whole = np.sqrt(np.bincount(self.family, ripple**2, 3))
        width = np.where(self.family > 0, np.minimum(tuned.PINS_OF_TURN * whole[self.family], ripple), 0.0)
        return _seen(width, self.wave, noise)


def _finite(columns: FloatArray) -> FloatArray:
    found: FloatArray = np.nan_to_num(columns, posinf=0.0, neginf=0.0)
    return found


def path_error(reducer: AsBuiltReducer, curve: LinearisedCurve, recording: Recording) -> FloatArray:
    """Columns of the error of the path of a loop, hat functions along it, shape (rows, columns).

    Their width is a share of the whole twist.
    """
    share = path_error_share(reducer)
    if recording.kind is not HYSTERESIS or not share:
        return np.zeros((recording.rows.size, 0))
    torque = recording.measurement["torque_nm"]
    path = np.cumsum(np.abs(np.diff(torque, prepend=torque[0]))) / (tuned.LOOP_PATH_STEP * np.max(np.abs(torque)))
    return share * _whole_twist(curve) * hat_functions(path[recording.rows], int(np.ceil(path[-1])) + 1)


def branch_error(
    reducer: AsBuiltReducer, curve: LinearisedCurve, recording: Recording, peak: float, size: float | None = None
) -> FloatArray:
    """The same with hat functions over the torque of each branch, up to ``peak`` [N·m], shape (rows, columns).

    ``size``: twist of which it is a share, the whole twist if None.
    """
    share = path_error_share(reducer)
    if not share:
        return np.zeros((recording.rows.size, 0))
    torque = recording.measurement["torque_nm"]
    branch = loop_branches(torque)[recording.rows]
    count = round(2.0 / tuned.LOOP_PATH_STEP) + 1
    hats = hat_functions((torque[recording.rows] / peak + 1.0) * 0.5 * (count - 1), count)
    sides = [hats * (branch == sign)[:, np.newaxis] for sign in (1.0, -1.0)]
    return share * (_whole_twist(curve) if size is None else size) * np.hstack(sides)


def row_error(reducer: AsBuiltReducer, curve: LinearisedCurve, recording: Recording) -> FloatArray:
    """One column for each row of a loop so close to zero torque on the stage that either flank may touch.

    The width at zero is the step between the flanks; shape (rows, such rows). Two files have nothing of this error in
    common.
    """
    if recording.kind is not HYSTERESIS:
        return np.zeros((recording.rows.size, 0))
    peak = float(np.max(np.abs(recording.measurement["torque_nm"]))) * NEWTON_METRE
    margin = NEAR_ZERO * peak + FRICTION_MARGIN * reducer.coulomb_torque
    near = np.maximum(1.0 - np.abs(curve.prediction.terms[0].through) / margin, 0.0)
    return _between_flanks(curve, near > 0.0) * np.diag(near)[:, near > 0.0]


def _between_flanks(curve: LinearisedCurve, near: BoolArray) -> float:
    """Step of the twist between rows ``near`` zero torque on either flank; the whole twist where one flank has none."""
    angle, through = curve.prediction.on_last_flank, curve.prediction.terms[0].through
    seen = near & np.isfinite(angle)
    first, second = (angle[seen & (through >= 0.0)], angle[seen & (through < 0.0)])
    if not (first.size and second.size):
        return _whole_twist(curve)
    return abs(float(np.median(first) - np.median(second)))


def _whole_twist(curve: LinearisedCurve) -> float:
    angle = curve.prediction.on_last_flank
    found = angle[np.isfinite(angle)]
    return float(np.ptp(found)) if found.size else 0.0


def order_error(
    reducer: AsBuiltReducer, recording: Recording, position: FloatArray, curve: LinearisedCurve, grown: FloatArray
) -> FloatArray:
    """Cosine and sine of the orders at which a reducer of equal parts can have a ripple, shape (rows, columns).

    Equal lobes and pins have one at multiples of their product. Holes for cranks and bolts make an elastic disc softer
    in some directions, so that it has one at all multiples of the pins. The width is the ripple of the errors that grow
    with the load, ``grown``, shape (rows, errors), since laws and bodies change each order by a factor of its own; with
    it, of the first products the accuracy of an order, of the bodies their whole ripple.
    """
    if not recording.kind.over_output_turn:
        return np.zeros((position.size, 0))
    lobes, pins = reducer.case.drive.trochoid.lobes, reducer.case.drive.trochoid.pins
    # The product comes first: rows at equal distances show some orders as others, and each counts once.
    others = np.arange(1, _FALLING * lobes + 1)
    multiple = np.concatenate([lobes * np.arange(1, tuned.PRODUCTS + 1), others[others % lobes > 0]])
    wave = np.exp(1j * np.outer(position, pins * multiple))
    first = distinct_waves(wave)
    wave = wave[:, first]
    predicted = np.nan_to_num(curve.prediction.on_last_flank)[:, np.newaxis]
    of_bodies = _ripple(predicted, wave)[:, 0] if reducer.case.disc_bodies else 0.0
    known = np.where(first < _FALLING, recording.accuracy, of_bodies)
    width = np.hypot(known, np.linalg.norm(_ripple(grown, wave), axis=1))
    return _seen(width, wave, recording.noise)


def _seen(width: FloatArray, wave: ComplexArray, noise: Noise) -> FloatArray:
    """Cosine and sine of each wave, of shape (rows, waves), times its width, but for those that the noise hides."""
    seen = width * np.sqrt(0.5 * len(wave)) > tuned.SEEN_ORDER * noise.sigma
    shown = width[seen] * wave[:, seen]
    return np.hstack([shown.real, shown.imag])


def _ripple(columns: FloatArray, wave: ComplexArray) -> FloatArray:
    """Amplitude of each ``wave`` in each column over a turn, shape (waves, columns)."""
    found: FloatArray = np.abs(wave.conj().T @ (columns - np.mean(columns, axis=0))) * (2.0 / len(columns))
    return found


def low_product_orders(trochoid: Trochoid) -> IntArray:
    """First orders per turn of the output at which equal lobes and pins leave a ripple, rising."""
    return trochoid.lobes * trochoid.pins * np.arange(1, _FALLING + 1)


def orders_of_turn(trochoid: Trochoid) -> FloatArray:
    """Orders per turn of the output that form errors have, and those of the mesh, rising."""
    return np.union1d(np.arange(1.0, tuned.LOW_ORDERS + 1.0), mesh_orders(trochoid))


def mesh_orders(trochoid: Trochoid) -> FloatArray:
    """Orders per turn of the output at which tooth and pins repeat, and their product, rising."""
    multiples = np.arange(1.0, _MULTIPLES + 1.0)
    mesh = float(trochoid.lobes * trochoid.pins)
    return np.unique([*(trochoid.lobes * multiples), *(trochoid.pins * multiples), mesh])


def smooth_columns(
    reducer: AsBuiltReducer, recording: Recording, position: FloatArray, lobe: FloatArray, phase: FloatArray
) -> FloatArray:
    """Columns of an error of any smooth form, each of size 1, shape (rows, columns).

    Of a scan: a form over the ``phase`` of the lobe that varies slowly round the disc, and an offset of each lobe. Of a
    turn: low orders and those of the mesh.
    """
    if recording.kind is PROFILE_SCAN:
        return forms_of_scan(reducer.case.profile, position, lobe, phase)
    return waves([*np.outer(position, orders_of_turn(reducer.case.drive.trochoid)).T])


def form_error(
    signature: FloatArray, reducer: AsBuiltReducer, recording: Recording, position: FloatArray, phase: FloatArray
) -> FloatArray:
    """Columns of the error in the form of one effect on a scan or turn: its ``signature``, shape (rows,), slowly
    modulated.

    Along lobe and disc for a scan (``phase`` of the lobe [rad]), along mesh and turn for a curve over a turn.
    """
    trochoid = reducer.case.drive.trochoid
    if recording.kind is PROFILE_SCAN:
        turn = position / trochoid.lobes
        return _modulated(signature, [phase, 2.0 * phase, 3.0 * phase, turn, 2.0 * turn])
    mesh = [k * reducer.discs * n * position for n in (trochoid.lobes, trochoid.pins) for k in (1, 2, 3)]
    # What is the same at all angles errs the same at all, but for the ripple of equal lobes and pins; what only moves
    # an unknown zero is not seen.
    mean = float(np.nanmean(signature))
    columns = _modulated(signature - mean, [position, 2.0 * position, *mesh])
    if recording.kind.zero_unknown:
        return columns
    ripple = [order * position for order in low_product_orders(trochoid)]
    return np.hstack([columns, _modulated(np.full(signature.size, mean), ripple)])


def _modulated(signature: FloatArray, angles: list[FloatArray]) -> FloatArray:
    columns: FloatArray = tuned.FORM * signature[:, np.newaxis] * waves(angles)
    return columns


def law_error(signature: FloatArray, reducer: AsBuiltReducer, recording: Recording) -> FloatArray:
    """Columns of the error of a joint whose law is not known: its ``signature`` on a loop, octave by octave of torque.

    A power law, a spring of rising stiffness and a curve of three slopes differ by as much; shape (rows, octaves). Of
    printed parts the error of the path is larger.
    """
    if path_error_share(reducer):
        return np.zeros((signature.size, 0))
    torque = np.abs(recording.measurement["torque_nm"])
    octave = np.log2(np.max(torque) / np.maximum(torque[recording.rows], 1e-9 * np.max(torque)))
    hats = hat_functions(np.minimum(octave, _OCTAVES - 1.0), _OCTAVES)
    return tuned.LAW_OF_JOINT * signature[:, np.newaxis] * hats


def form_error_of_loop(signature: FloatArray, curve: LinearisedCurve, recording: Recording) -> FloatArray:
    """Columns of the error in the form of one effect on a loop: its ``signature``, shape (rows,), modulated with torque
    and branch.

    Elastic effects follow the torque alone; only what depends on the path can err in its path.
    """
    peak = float(np.max(np.abs(recording.measurement["torque_nm"])))
    whole = recording.measurement["torque_nm"] / peak
    direction = load_direction(whole)
    direction[0] = direction[1]
    t, branch = whole[recording.rows], direction[recording.rows]
    past = torque_since_reversal(whole, direction)[recording.rows]
    smooth = np.stack([np.ones_like(t), t, t * t, t**3, np.sign(t), np.abs(t)], axis=1)
    elastic = smooth @ np.linalg.lstsq(smooth, signature, rcond=None)[0]
    path = signature - elastic
    slow = [elastic * t, elastic * t * t, elastic * t**3, path * t, path * branch, path * branch * t]
    # Friction that sticks turns from one side to the other over twice its torque, friction that slips at once, and that
    # of many contacts bit by bit: they differ by triangles of about that length. The length follows the friction of
    # the model without steps, each of which would be another minimum of the misfit. Without friction nothing sticks.
    full = branch * float(np.max(np.abs(path), initial=0.0))
    friction = np.abs(t - curve.prediction.terms[0].through / (peak * NEWTON_METRE))
    stick = 2.0 * float(np.max(friction, initial=_LEAST_FRICTION))
    after = [np.maximum(1.0 - past / (share * stick), 0.0) * full for share in _STICKS]
    return np.stack([*(tuned.FORM * one for one in slow), *(tuned.REVERSAL * one for one in after)], axis=1)


def _coupled(at: LoadedContacts, reducer: AsBuiltReducer, pitches: float) -> FloatArray:
    """Force on neighbouring pins of the same disc, with weights that decay over ``pitches``, per mean force."""
    pins = reducer.case.drive.trochoid.pins
    poses = int(np.max(at.pose, initial=-1)) + 1
    force = np.zeros((poses, at.discs, pins))
    force[at.pose, at.disc, at.pin] = at.force
    apart = np.minimum(np.arange(pins), pins - np.arange(pins))
    kernel = np.exp(-apart / pitches)
    spread = np.fft.irfft(np.fft.rfft(force) * np.fft.rfft(kernel / kernel.sum()), pins)
    found: FloatArray = spread[at.pose, at.disc, at.pin] / float(np.mean(at.force))
    return found
