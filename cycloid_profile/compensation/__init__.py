"""Deformation compensation: the fixed point of tooth profile and load sharing."""

from cycloid_profile.compensation.even_load import EvenLoad as EvenLoad
from cycloid_profile.compensation.even_load import even_load_profile as even_load_profile
from cycloid_profile.compensation.fixed_point import Compensation as Compensation
from cycloid_profile.compensation.fixed_point import LoadSharingSolver as LoadSharingSolver
from cycloid_profile.compensation.fixed_point import compensate as compensate
from cycloid_profile.compensation.fixed_point import compensate_by as compensate_by
