"""Measured files with hidden effects, from physics of their own: nothing here imports the package under test."""

from .cases import Case, draw_case
from .contact import Body, Law, PowerLaw, ReferenceDepth, Roark
from .effects import KINDS, OUTSIDE
from .hidden import Hidden
from .loop import loop
from .noise import Noise
from .reducer import REDUCERS, Reducer, spec_text
from .scan import scan
from .stage import Stage
from .turn import lost_motion, transmission_error
from .wide import draw_wide

__all__ = [
    "KINDS",
    "OUTSIDE",
    "REDUCERS",
    "Body",
    "Case",
    "Hidden",
    "Law",
    "Noise",
    "PowerLaw",
    "Reducer",
    "ReferenceDepth",
    "Roark",
    "Stage",
    "draw_case",
    "draw_wide",
    "loop",
    "lost_motion",
    "scan",
    "spec_text",
    "transmission_error",
]
