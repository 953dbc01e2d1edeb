"""Equilibrium of the whole stage: carrier and discs on elastic bearings, and its tangent."""

from cycloid_profile.contact.stage.energy import EnergyPoint as EnergyPoint
from cycloid_profile.contact.stage.energy import StageEnergy as StageEnergy
from cycloid_profile.contact.stage.energy import minimise as minimise
from cycloid_profile.contact.stage.equilibrium import StageEquilibrium as StageEquilibrium
from cycloid_profile.contact.stage.loaded_contacts import ContactChange as ContactChange
from cycloid_profile.contact.stage.loaded_contacts import ContactPoints as ContactPoints
from cycloid_profile.contact.stage.loaded_contacts import CurvedContacts as CurvedContacts
from cycloid_profile.contact.stage.loaded_contacts import LoadedContacts as LoadedContacts
from cycloid_profile.contact.stage.over_width import WidthState as WidthState
from cycloid_profile.contact.stage.tangent import StageTangent as StageTangent
from cycloid_profile.contact.stage.tangent import energy_about as energy_about
from cycloid_profile.contact.stage.tangent import energy_with as energy_with
