"""Errors a user can act on: one sentence with what, its value, the limit and the remedy."""

from __future__ import annotations


class CycloidError(Exception):
    """Base of every error this package raises on purpose.

    Attributes
    ----------
    what : name of the quantity or key at fault
    value : the value it had
    limit : the rule it broke, as a clause ("must be below 1")
    remedy : what to do, as a clause ("lower eccentricity_mm below 1.600")
    """

    exit_code = 2

    def __init__(self, what: str, value: object, limit: str, remedy: str) -> None:
        self.what, self.value, self.limit, self.remedy = what, value, limit, remedy
        super().__init__(f"{what} = {value} {limit}: {remedy}")


class SpecError(CycloidError):
    """A spec file that cannot be read, or a key in it with an impossible value."""


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


class ExportError(CycloidError):
    """A file that cannot be written."""
