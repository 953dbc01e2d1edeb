"""Line contact of a pin and a tooth: Hertzian pressure and laws of approach."""

from cycloid_profile.contact.laws.compiled import CompiledLaw as CompiledLaw
from cycloid_profile.contact.laws.contact_law import ContactLaw as ContactLaw
from cycloid_profile.contact.laws.contact_law import Response as Response
from cycloid_profile.contact.laws.contact_law import contact_constants as contact_constants
from cycloid_profile.contact.laws.contact_law import response as response
from cycloid_profile.contact.laws.derived import LawFromApproach as LawFromApproach
from cycloid_profile.contact.laws.derived import OnSpring as OnSpring
from cycloid_profile.contact.laws.derived import compiled_law as compiled_law
from cycloid_profile.contact.laws.hertz import STEEL as STEEL
from cycloid_profile.contact.laws.hertz import LineContact as LineContact
from cycloid_profile.contact.laws.hertz import Material as Material
from cycloid_profile.contact.laws.library import LAWS as LAWS
from cycloid_profile.contact.laws.library import ArticleLogarithm as ArticleLogarithm
from cycloid_profile.contact.laws.library import Braendlein as Braendlein
from cycloid_profile.contact.laws.library import Johnson as Johnson
from cycloid_profile.contact.laws.library import Logarithmic as Logarithmic
from cycloid_profile.contact.laws.library import Palmgren as Palmgren
from cycloid_profile.contact.laws.library import Roark as Roark
from cycloid_profile.contact.laws.library import WeberBanaschek as WeberBanaschek
