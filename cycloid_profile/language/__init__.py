"""Language of what people read: English texts and their translations, looked up where a text leaves the package."""

from cycloid_profile.language.choice import ENGLISH as ENGLISH
from cycloid_profile.language.choice import VARIABLE as VARIABLE
from cycloid_profile.language.choice import chosen_language as chosen_language
from cycloid_profile.language.choice import error_sentences as error_sentences
from cycloid_profile.language.choice import languages as languages
from cycloid_profile.language.choice import translated as translated
from cycloid_profile.language.choice import use_language as use_language
