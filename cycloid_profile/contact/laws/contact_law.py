"""Protocol of a law of approach, the form in which compiled kernels evaluate it, and the band after Hertz.

A law gives the approach of pin and tooth under the force on one pin, in the ``LineContact`` where it acts. Force,
stiffness and energy follow from ``_kernels.response``, whatever the law.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from cycloid_profile.arrays import ArrayLike, BoolArray, FloatArray
from cycloid_profile.contact.laws.compiled import CompiledLaw
from cycloid_profile.contact.laws.hertz import LineContact

# A band wider than this share of the smaller radius is no longer narrow; Hertz's own assumption.
_NARROW = 0.1


class Response(NamedTuple):
    """``force`` [N], tangent ``stiffness`` [N/mm] and ``energy`` ∫F dδ [N·mm] at an approach."""

    force: FloatArray
    stiffness: FloatArray
    energy: FloatArray


def contact_constants(law: CompiledLaw, contact: LineContact) -> FloatArray:
    """Law constant of each contact; array shape of ``contact.curvature``."""
    from cycloid_profile.contact.laws._kernels import constants

    found: FloatArray = constants(law, np.ascontiguousarray(contact.curvature))
    return found


def response(law: CompiledLaw, approach: ArrayLike, contact: LineContact) -> Response:
    """Force, stiffness and energy at approaches of any sign, broadcast against the contacts."""
    from cycloid_profile.contact.laws._kernels import responses

    delta = np.asarray(approach, dtype=np.float64) + np.zeros_like(contact.curvature)
    curvature = contact.curvature + np.zeros_like(delta)
    found = responses(law, curvature.ravel(), delta.ravel())
    return Response(*(values.reshape(delta.shape) for values in found))


class ContactLaw(Protocol):
    """Approach of pin and tooth under a force, and back. Shapes broadcast against ``contact.curvature``.

    ``LawFromApproach`` makes one of a single function.
    """

    @property
    def name(self) -> str:
        """Name shown to the user and written in the spec file."""
        ...

    @property
    def source(self) -> str:
        """Publication of the law."""
        ...

    @property
    def validity(self) -> str:
        """Range of validity in one sentence; ``within_range`` tests the part that has numbers."""
        ...

    def approach(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """Approach δ [mm] under ``force`` ≥ 0 [N]."""
        ...

    def force(self, approach: ArrayLike, contact: LineContact) -> FloatArray:
        """Force [N] at an ``approach`` [mm]; 0 where the approach is not positive."""
        ...

    def stiffness(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """Tangent stiffness dF/dδ at ``force`` > 0 [N/mm]."""
        ...

    def response(self, approach: FloatArray, contact: LineContact) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Force [N], tangent stiffness [N/mm] and energy ∫F dδ [N·mm] at an ``approach`` > 0 [mm]."""
        ...

    def within_range(self, force: ArrayLike, contact: LineContact) -> BoolArray:
        """Whether ``force`` lies where the law may be used."""
        ...

    def half_width(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """Half-width of the contact band that the law assumes [mm]."""
        ...

    def peak_pressure(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """Peak pressure p0 over that band [MPa]."""
        ...

    def subsurface_shear(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """Largest shear stress under the surface [MPa]."""
        ...


@runtime_checkable
class Compilable(Protocol):
    """A law that provides a compiled form; any other is tabulated (``compiled_law``)."""

    def compiled(self, contact: LineContact) -> CompiledLaw:
        """The law in contacts of this width, pin and pair of materials, of any curvature."""
        ...


class HertzBand:
    """Base of laws: the contact band and its stresses after Hertz, force and stiffness from the compiled form."""

    __slots__ = ()

    def compiled(self, contact: LineContact) -> CompiledLaw:
        """See ``Compilable.compiled``."""
        raise NotImplementedError

    def response(self, approach: FloatArray, contact: LineContact) -> tuple[FloatArray, FloatArray, FloatArray]:
        """See ``ContactLaw.response``."""
        return response(self.compiled(contact), approach, contact)

    def force(self, approach: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.force``."""
        delta = np.asarray(approach, dtype=np.float64) + np.zeros_like(contact.curvature)
        some = replace(contact, curvature=contact.curvature + np.zeros_like(delta))
        F: FloatArray = np.where(delta > 0.0, self.response(np.where(delta > 0.0, delta, 1.0), some)[0], 0.0)
        return F

    def half_width(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.half_width``."""
        return contact.half_width(force)

    def peak_pressure(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.peak_pressure``."""
        return contact.peak_pressure(force)

    def subsurface_shear(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.subsurface_shear``."""
        return contact.subsurface_shear(force)

    def within_range(self, force: ArrayLike, contact: LineContact) -> BoolArray:
        """See ``ContactLaw.within_range``: the band is narrow against both radii."""
        smaller = np.minimum(contact.pin_radius, contact.tooth_radius)
        narrow: BoolArray = contact.half_width(force) <= _NARROW * smaller
        return narrow
