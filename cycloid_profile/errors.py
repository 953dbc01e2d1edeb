"""Errors a user can act on: one sentence with what, its value, the limit and the remedy."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any


class CycloidError(Exception):
    """Base of every error this package raises on purpose.

    Attributes
    ----------
    what : name of the quantity or key at fault
    value : the value it had
    limit : the rule it broke, as a clause ("is outside (0, 1)")
    remedy : what to do, as a clause ("keep the eccentricity below 1.600 mm")
    joint : text between name and value
    """

    exit_code = 2

    def __init__(self, what: str, value: object, limit: str, remedy: str, joint: str = " = ") -> None:
        self.what, self.value, self.limit, self.remedy, self.joint = what, value, limit, remedy, joint
        super().__init__(f"{what}{joint}{value} {limit}: {remedy}")

    @property
    def sentences(self) -> tuple[str, ...]:
        """The error in one sentence, or in one for each fault."""
        return (str(self),)

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (type(self), dict(vars(self)), self.args)

    def renamed(self, what: str) -> CycloidError:
        """The same error under another name, such as the key of a file."""
        return type(self)(what, self.value, self.limit, self.remedy)


def _restored(kind: type[CycloidError], state: dict[str, Any], args: tuple[Any, ...]) -> CycloidError:
    """The error from another process."""
    error = kind.__new__(kind, *args)
    error.__dict__.update(state)
    return error


class SpecError(CycloidError):
    """A spec file that cannot be read, or keys in it with an impossible value; ``faults`` holds each of them."""

    faults: tuple[SpecError, ...] = ()

    @classmethod
    def of(cls, faults: Iterable[SpecError]) -> SpecError:
        """The fault, or one error of several; its parts are those of the first."""
        first, *others = faults
        if not others:
            return first
        error = cls(first.what, first.value, first.limit, first.remedy)
        error.faults = (first, *others)
        error.args = ("; ".join(map(str, error.faults)),)
        return error

    @property
    def sentences(self) -> tuple[str, ...]:
        """One sentence for each fault."""
        return tuple(map(str, self.faults)) or (str(self),)


class GeometryError(CycloidError):
    """A tooth that cannot exist: K1 ≥ 1, pins that overlap, undercut."""


class LoadError(CycloidError):
    """A load case without meaning: zero torque, a width or stiffness that is not positive."""


class SolveError(CycloidError):
    """A solve that ended without an answer."""

    exit_code = 1


class CompensationError(CycloidError):
    """A deformation compensation that would leave less than zero backlash."""

    exit_code = 1


class AllocationError(CycloidError):
    """Tolerances that cannot reach the yield asked for, however fine."""

    exit_code = 1


class MeasurementError(CycloidError):
    """A measured file that cannot be read, or is not what it says."""


class ExportError(CycloidError):
    """A file that cannot be written."""


class ResourceError(CycloidError):
    """Input that needs more memory, disk or time than is taken without permission."""


class ToleranceError(CycloidError):
    """A tolerance study that cannot be run: no scheduler, no place for its samples."""


class PluginError(CycloidError):
    """A plug-in that cannot be loaded, or an effect of it that is incomplete."""


def nearest_name(word: str, known: Iterable[str]) -> str | None:
    """The known name most like ``word``, None where none is."""
    return next(iter(difflib.get_close_matches(word, list(known), n=1, cutoff=0.4)), None)


def did_you_mean(word: str, known: Iterable[str], otherwise: str) -> str:
    """Remedy of a misspelt name: the nearest known one, or the clause ``otherwise``."""
    close = nearest_name(word, known)
    return f"did you mean {close}?" if close else otherwise
