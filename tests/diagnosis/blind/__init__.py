"""Measured files with hidden effects, from physics of their own: nothing here imports the package under test."""

from .cases import Case, draw_case
from .effects import KINDS, OUTSIDE
from .hidden import Hidden
from .loop import loop
from .noise import Noise
from .reducer import Reducer, spec_text
from .scan import scan
from .stage import Stage
from .turn import lost_motion, transmission_error

__all__ = [
    "KINDS",
    "OUTSIDE",
    "Case",
    "Hidden",
    "Noise",
    "Reducer",
    "Stage",
    "draw_case",
    "loop",
    "lost_motion",
    "scan",
    "spec_text",
    "transmission_error",
]
