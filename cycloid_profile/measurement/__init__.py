"""Measured files: their kinds, columns and keys, read and written."""

from cycloid_profile.measurement.files import FORMAT as FORMAT
from cycloid_profile.measurement.files import Measurement as Measurement
from cycloid_profile.measurement.files import PendingSteps as PendingSteps
from cycloid_profile.measurement.files import format_measurement as format_measurement
from cycloid_profile.measurement.files import parse_measurement as parse_measurement
from cycloid_profile.measurement.files import scanned_disc as scanned_disc
from cycloid_profile.measurement.foreign import MeasurementReader as MeasurementReader
from cycloid_profile.measurement.foreign import SourceTable as SourceTable
from cycloid_profile.measurement.foreign import parse_columns as parse_columns
from cycloid_profile.measurement.foreign import register_reader as register_reader
from cycloid_profile.measurement.kinds import HYSTERESIS as HYSTERESIS
from cycloid_profile.measurement.kinds import KINDS as KINDS
from cycloid_profile.measurement.kinds import LOST_MOTION_MAP as LOST_MOTION_MAP
from cycloid_profile.measurement.kinds import PROFILE_SCAN as PROFILE_SCAN
from cycloid_profile.measurement.kinds import TRANSMISSION_ERROR as TRANSMISSION_ERROR
from cycloid_profile.measurement.kinds import Hysteresis as Hysteresis
from cycloid_profile.measurement.kinds import LostMotionMap as LostMotionMap
from cycloid_profile.measurement.kinds import MeasurementKind as MeasurementKind
from cycloid_profile.measurement.kinds import ProfileScan as ProfileScan
from cycloid_profile.measurement.kinds import TransmissionErrorCurve as TransmissionErrorCurve
from cycloid_profile.measurement.kinds import kind_named as kind_named
from cycloid_profile.measurement.reading import read_measurement as read_measurement
from cycloid_profile.measurement.reading import read_measurements as read_measurements
from cycloid_profile.measurement.reading import remember_columns as remember_columns
