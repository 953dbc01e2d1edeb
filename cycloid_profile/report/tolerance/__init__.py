"""Reports of a tolerance analysis."""

from cycloid_profile.report.tolerance.json_output import to_json as to_json
from cycloid_profile.report.tolerance.package import write_tolerance as write_tolerance
from cycloid_profile.report.tolerance.text import allocation_sentences as allocation_sentences
from cycloid_profile.report.tolerance.text import headline as headline
from cycloid_profile.report.tolerance.text import summary_sentences as summary_sentences
from cycloid_profile.report.tolerance.text import terminal_tables as terminal_tables
from cycloid_profile.report.tolerance.text import tolerance_meaning as tolerance_meaning
