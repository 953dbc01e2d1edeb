"""Measured files of other programs: what their cells mean, as one of the four kinds."""

from cycloid_profile.measurement.foreign.conversion import measurement_of as measurement_of
from cycloid_profile.measurement.foreign.encoding import decode as decode
from cycloid_profile.measurement.foreign.mapping import MAPPING_FILE as MAPPING_FILE
from cycloid_profile.measurement.foreign.mapping import ColumnMapping as ColumnMapping
from cycloid_profile.measurement.foreign.mapping import ColumnSource as ColumnSource
from cycloid_profile.measurement.foreign.mapping import mapping_for as mapping_for
from cycloid_profile.measurement.foreign.mapping import parse_columns as parse_columns
from cycloid_profile.measurement.foreign.mapping import place_of as place_of
from cycloid_profile.measurement.foreign.mapping import remember as remember
from cycloid_profile.measurement.foreign.mapping import remembered as remembered
from cycloid_profile.measurement.foreign.readers import MeasurementReader as MeasurementReader
from cycloid_profile.measurement.foreign.readers import read_source as read_source
from cycloid_profile.measurement.foreign.readers import register_reader as register_reader
from cycloid_profile.measurement.foreign.table import SourceTable as SourceTable
