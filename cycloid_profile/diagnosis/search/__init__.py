"""Search for the set of effects that explains the files."""

from cycloid_profile.diagnosis.search.lobe_index import index_lobes as index_lobes
from cycloid_profile.diagnosis.search.seam import seam_notes as seam_notes
from cycloid_profile.diagnosis.search.search import SearchResult as SearchResult
from cycloid_profile.diagnosis.search.search import search_effects as search_effects
from cycloid_profile.diagnosis.search.symmetric_parts import on_other_parts as on_other_parts
