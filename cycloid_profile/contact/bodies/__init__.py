"""Part deviations, the bearings that carry the discs, elastic discs, and elastic supports of pins and carrier."""

from cycloid_profile.contact.bodies.bearings import SupportModel as SupportModel
from cycloid_profile.contact.bodies.bearings import crank_turn_per_carrier_turn as crank_turn_per_carrier_turn
from cycloid_profile.contact.bodies.bearings import support_misfit as support_misfit
from cycloid_profile.contact.bodies.bearings import support_model as support_model
from cycloid_profile.contact.bodies.deviations import NO_DEVIATIONS as NO_DEVIATIONS
from cycloid_profile.contact.bodies.deviations import PartDeviations as PartDeviations
from cycloid_profile.contact.bodies.elastic_disc import DiscCompliance as DiscCompliance
from cycloid_profile.contact.bodies.elastic_disc import compiled_discs as compiled_discs
from cycloid_profile.contact.bodies.elastic_disc import disc_compliance as disc_compliance
from cycloid_profile.contact.bodies.elastic_disc import places_on_discs as places_on_discs
from cycloid_profile.contact.bodies.elastic_disc import read_disc_compliance as read_disc_compliance
from cycloid_profile.contact.bodies.elastic_disc import stage_compliance as stage_compliance
from cycloid_profile.contact.bodies.pin_seats import PinSeats as PinSeats
from cycloid_profile.contact.bodies.radial_bearing import CLEARANCE_CLASSES as CLEARANCE_CLASSES
from cycloid_profile.contact.bodies.radial_bearing import BearingLaw as BearingLaw
from cycloid_profile.contact.bodies.radial_bearing import BearingResponse as BearingResponse
from cycloid_profile.contact.bodies.radial_bearing import LinearBearing as LinearBearing
from cycloid_profile.contact.bodies.radial_bearing import RollerBearing as RollerBearing
from cycloid_profile.contact.bodies.radial_bearing import bearing_law as bearing_law
from cycloid_profile.contact.bodies.radial_bearing import clearance_range as clearance_range
from cycloid_profile.contact.bodies.radial_bearing import roller_constant as roller_constant
from cycloid_profile.contact.bodies.radial_bearing import softened_support as softened_support
from cycloid_profile.contact.bodies.ring_body import RingBody as RingBody
from cycloid_profile.contact.bodies.supports import Pillars as Pillars
from cycloid_profile.contact.bodies.supports import Supports as Supports
from cycloid_profile.contact.bodies.supports import pin_normals as pin_normals
