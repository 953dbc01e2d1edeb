"""Tables of the spec file: every key with its unit, default, limits and remedy."""

from cycloid_profile.spec.model._table import Table as Table
from cycloid_profile.spec.model.drive import CranksSpec as CranksSpec
from cycloid_profile.spec.model.drive import DiscSpec as DiscSpec
from cycloid_profile.spec.model.drive import DriveSpec as DriveSpec
from cycloid_profile.spec.model.effects import EMPIRICAL_LABEL as EMPIRICAL_LABEL
from cycloid_profile.spec.model.effects import EMPIRICAL_NAMES as EMPIRICAL_NAMES
from cycloid_profile.spec.model.effects import PLUGIN_GROUP as PLUGIN_GROUP
from cycloid_profile.spec.model.effects import DataFileSpec as DataFileSpec
from cycloid_profile.spec.model.effects import EmpiricalSpec as EmpiricalSpec
from cycloid_profile.spec.model.effects import installed_effects as installed_effects
from cycloid_profile.spec.model.effects import registered_names as registered_names
from cycloid_profile.spec.model.effects import remedy_of_unknown_effect as remedy_of_unknown_effect
from cycloid_profile.spec.model.export import DrawingSpec as DrawingSpec
from cycloid_profile.spec.model.export import ExportSpec as ExportSpec
from cycloid_profile.spec.model.export import Format as Format
from cycloid_profile.spec.model.export import GrindingSpec as GrindingSpec
from cycloid_profile.spec.model.export import WireSpec as WireSpec
from cycloid_profile.spec.model.load import LoadSpec as LoadSpec
from cycloid_profile.spec.model.load import MaterialSpec as MaterialSpec
from cycloid_profile.spec.model.load import MaterialsSpec as MaterialsSpec
from cycloid_profile.spec.model.modification import EFFECT_NAMES as EFFECT_NAMES
from cycloid_profile.spec.model.modification import ModificationSpec as ModificationSpec
from cycloid_profile.spec.model.spec import Quality as Quality
from cycloid_profile.spec.model.spec import Spec as Spec
from cycloid_profile.spec.model.tolerance import ReferenceSpec as ReferenceSpec
from cycloid_profile.spec.model.tolerance import ToleranceSpec as ToleranceSpec
