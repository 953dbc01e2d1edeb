"""Empirical effects: curves fitted to a measured gap that no named effect explains, with their fit."""

from cycloid_profile.effects.empirical.deviations import Empirical as Empirical
from cycloid_profile.effects.empirical.deviations import FormDeviation as FormDeviation
from cycloid_profile.effects.empirical.deviations import TorqueTwistResidual as TorqueTwistResidual
from cycloid_profile.effects.empirical.deviations import data_file as data_file
from cycloid_profile.effects.empirical.deviations import empirical_from_spec as empirical_from_spec
from cycloid_profile.effects.empirical.deviations import empirical_to_table as empirical_to_table
from cycloid_profile.effects.empirical.fit import fit_torque_twist as fit_torque_twist
from cycloid_profile.effects.empirical.fit import form_deviation_of as form_deviation_of
