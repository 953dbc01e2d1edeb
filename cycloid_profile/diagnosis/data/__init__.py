"""Measured files made ready: rows, noise, repeats, refusals."""

from cycloid_profile.diagnosis.data.noise import SCATTER_OF_ESTIMATE as SCATTER_OF_ESTIMATE
from cycloid_profile.diagnosis.data.noise import Noise as Noise
from cycloid_profile.diagnosis.data.noise import Values as Values
from cycloid_profile.diagnosis.data.noise import sidak as sidak
from cycloid_profile.diagnosis.data.noise import upper_tail as upper_tail
from cycloid_profile.diagnosis.data.recording import Recording as Recording
from cycloid_profile.diagnosis.data.recording import for_validation_only as for_validation_only
from cycloid_profile.diagnosis.data.recording import record as record
from cycloid_profile.diagnosis.data.recording import use_all_rows as use_all_rows
from cycloid_profile.diagnosis.data.repeats import with_drift_of_instrument as with_drift_of_instrument
from cycloid_profile.diagnosis.data.repeats import with_noise_of_repeats as with_noise_of_repeats
from cycloid_profile.diagnosis.data.screening import require_new_rows as require_new_rows
from cycloid_profile.diagnosis.data.screening import screen as screen
from cycloid_profile.diagnosis.data.screening import screen_files as screen_files
