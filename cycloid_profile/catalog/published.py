"""Budgets that articles published, figures as printed, one TOML each in ``articles``."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib import resources

import msgspec

from cycloid_profile.spec.table import Table


class PublishedSensitivity(Table, frozen=True):
    """One row of the table of [TP]: a factor with its sensitivity [′/mm] and its weight."""

    number: int
    factor: str
    arcmin_per_mm: float
    weight: float


class ToothProfileArticle(Table, frozen=True):
    """[TP]: the sensitivity table of the drive ``drive`` of the catalogue."""

    title: str
    drive: str
    sensitivities: tuple[PublishedSensitivity, ...]


class PublishedPart(Table, frozen=True):
    """One part of the budget of [LM]: mean and the number after its ± [′]."""

    mean_arcmin: float
    tolerance_arcmin: float


class PublishedTotal(Table, frozen=True):
    """The total of [LM] as its table and text print it [′]."""

    mean_arcmin: float
    tolerance_arcmin: float
    low_arcmin: float
    high_arcmin: float


class PublishedMonteCarlo(Table, frozen=True):
    """The simulation of [LM]: mean ± [′] of so many runs."""

    mean_arcmin: float
    plus_minus_arcmin: float
    runs: int


class PlusMinus(Table, frozen=True):
    """Tolerances ± of the parameter table of [LM] [µm]."""

    normal_length_um: float
    centre_distance_um: float
    gear_runout_um: float
    pin_um: float
    disc_um: float
    bearing_um: float


class LostMotionArticle(Table, frozen=True):
    """[LM]: parts and total of its lost-motion budget, and the parameters it prints."""

    title: str
    ratio: float
    sun_diameter_mm: float
    pressure_angle_deg: float
    plus_minus: PlusMinus
    involute: PublishedPart
    cycloid: PublishedPart
    bearing: PublishedPart
    total: PublishedTotal
    monte_carlo: PublishedMonteCarlo


@cache
def tooth_profile_article() -> ToothProfileArticle:
    """What [TP] prints."""
    return msgspec.convert(_tables("tooth_profile"), ToothProfileArticle)


@cache
def lost_motion_article() -> LostMotionArticle:
    """What [LM] prints."""
    return msgspec.convert(_tables("lost_motion"), LostMotionArticle)


def _tables(name: str) -> object:
    folder = resources.files("cycloid_profile.catalog") / "articles"
    return tomllib.loads((folder / f"{name}.toml").read_text(encoding="utf-8"))
