"""Published sensitivities and lost-motion budgets, figures as printed, one TOML each in ``articles``."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib import resources

import msgspec

from cycloid_profile.spec.model import Table


class PublishedSensitivity(Table, frozen=True):
    """One row of the table of [TP]: a factor, its sensitivity [′/mm] and its share in the sum of all."""

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


class PublishedTotal(PublishedPart, frozen=True):
    """Published total of the budget [LM], in its table and in its text [′]."""

    low_arcmin: float
    high_arcmin: float


class PublishedMonteCarlo(Table, frozen=True):
    """The simulation of [LM]: mean ± its confidence [′] over ``runs`` simulated reducers."""

    mean_arcmin: float
    plus_minus_arcmin: float
    runs: int


class PublishedTolerances(Table, frozen=True):
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
    plus_minus: PublishedTolerances
    involute: PublishedPart
    cycloid: PublishedPart
    bearing: PublishedPart
    total: PublishedTotal
    monte_carlo: PublishedMonteCarlo


@cache
def tooth_profile_article() -> ToothProfileArticle:
    """Published numbers of the tooth-profile article [TP]."""
    return msgspec.convert(_load_article("tooth_profile"), ToothProfileArticle)


@cache
def lost_motion_article() -> LostMotionArticle:
    """Published numbers of the lost-motion article [LM]."""
    return msgspec.convert(_load_article("lost_motion"), LostMotionArticle)


def _load_article(name: str) -> object:
    folder = resources.files("cycloid_profile.catalog") / "articles"
    return tomllib.loads((folder / f"{name}.toml").read_text(encoding="utf-8"))
