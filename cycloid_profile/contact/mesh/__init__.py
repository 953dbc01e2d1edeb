"""Pins against the tooth curve: meshing positions, foot points, gaps and backlash."""

from cycloid_profile.contact.mesh.foot_point import Gaps as Gaps
from cycloid_profile.contact.mesh.foot_point import capture_radius as capture_radius
from cycloid_profile.contact.mesh.foot_point import gaps as gaps
from cycloid_profile.contact.mesh.foot_point import nearest_foot as nearest_foot
from cycloid_profile.contact.mesh.meshing import Meshing as Meshing
from cycloid_profile.contact.mesh.meshing import finite_angles as finite_angles
from cycloid_profile.contact.mesh.meshing import mesh as mesh
from cycloid_profile.contact.mesh.meshing import mesh_cycle as mesh_cycle
from cycloid_profile.contact.mesh.meshing import output_turn as output_turn
from cycloid_profile.contact.mesh.meshing import remembered_mesh as remembered_mesh
from cycloid_profile.contact.mesh.touch import LEAST_REACH as LEAST_REACH
from cycloid_profile.contact.mesh.touch import OVERLAP_TOLERANCE as OVERLAP_TOLERANCE
from cycloid_profile.contact.mesh.touch import Backlash as Backlash
from cycloid_profile.contact.mesh.touch import backlash as backlash
from cycloid_profile.contact.mesh.touch import closing_turn as closing_turn
from cycloid_profile.contact.mesh.touch import first_order_backlash as first_order_backlash
from cycloid_profile.contact.mesh.touch import first_touch as first_touch
from cycloid_profile.contact.mesh.touch import input_locked_factor as input_locked_factor
