"""The spec file: TOML text to frozen, validated values and back."""

from cycloid_profile.spec.io import SCHEMA_FILE as SCHEMA_FILE
from cycloid_profile.spec.io import format_spec as format_spec
from cycloid_profile.spec.io import key_reference as key_reference
from cycloid_profile.spec.io import parse_spec as parse_spec
from cycloid_profile.spec.io import plain_text as plain_text
from cycloid_profile.spec.io import read_spec as read_spec
from cycloid_profile.spec.io import spec_schema as spec_schema
from cycloid_profile.spec.io import toml_values as toml_values
from cycloid_profile.spec.io import unreadable as unreadable
from cycloid_profile.spec.model import Quality as Quality
from cycloid_profile.spec.model import Spec as Spec
from cycloid_profile.spec.model.checks._validation import validated as validated
