"""Solids, assemblies and meshes: STEP, STL and 3MF."""

from cycloid_profile.export.cad.mesh import Mesh as Mesh
from cycloid_profile.export.cad.mesh import MeshExporter as MeshExporter
from cycloid_profile.export.cad.mesh import extruded as extruded
from cycloid_profile.export.cad.mesh import open_edges as open_edges
from cycloid_profile.export.cad.mesh import printed as printed
from cycloid_profile.export.cad.mesh import tooth_chords as tooth_chords
from cycloid_profile.export.cad.parts import CadMaterial as CadMaterial
from cycloid_profile.export.cad.parts import Part as Part
from cycloid_profile.export.cad.parts import Placement as Placement
from cycloid_profile.export.cad.parts import disc_placements as disc_placements
from cycloid_profile.export.cad.parts import mounted as mounted
from cycloid_profile.export.cad.parts import ring_bore as ring_bore
from cycloid_profile.export.cad.parts import stage_parts as stage_parts
from cycloid_profile.export.cad.step import StepAssemblyExporter as StepAssemblyExporter
from cycloid_profile.export.cad.step import StepExporter as StepExporter
