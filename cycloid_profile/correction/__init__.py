"""Grinding program that cancels the repeatable flank errors of a diagnosis."""

from cycloid_profile.correction.correction_path import Correction as Correction
from cycloid_profile.correction.correction_path import correction as correction
from cycloid_profile.correction.expected_scans import ExpectedScan as ExpectedScan
from cycloid_profile.correction.json_output import correction_to_json as correction_to_json
