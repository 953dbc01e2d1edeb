"""Solids, assemblies and meshes: STEP, STL and 3MF."""

from cycloid_profile.export.cad.areas import plate_measures as plate_measures
from cycloid_profile.export.cad.mesh import Mesh as Mesh
from cycloid_profile.export.cad.mesh import MeshExporter as MeshExporter
from cycloid_profile.export.cad.mesh import enlarged as enlarged
from cycloid_profile.export.cad.mesh import extruded as extruded
from cycloid_profile.export.cad.mesh import open_edges as open_edges
from cycloid_profile.export.cad.mesh import print_offsets as print_offsets
from cycloid_profile.export.cad.mesh import printed as printed
from cycloid_profile.export.cad.mesh import tooth_chords as tooth_chords
from cycloid_profile.export.cad.part_files import BomExporter as BomExporter
from cycloid_profile.export.cad.part_files import PartMeshExporter as PartMeshExporter
from cycloid_profile.export.cad.part_files import PartStepExporter as PartStepExporter
from cycloid_profile.export.cad.parts import CadMaterial as CadMaterial
from cycloid_profile.export.cad.parts import CadPart as CadPart
from cycloid_profile.export.cad.parts import OutputPins as OutputPins
from cycloid_profile.export.cad.parts import Placement as Placement
from cycloid_profile.export.cad.parts import PrintOffsets as PrintOffsets
from cycloid_profile.export.cad.parts import disc_placements as disc_placements
from cycloid_profile.export.cad.parts import mounted as mounted
from cycloid_profile.export.cad.parts import ring_bore as ring_bore
from cycloid_profile.export.cad.parts import stage_parts as stage_parts
from cycloid_profile.export.cad.step import StepAssemblyExporter as StepAssemblyExporter
from cycloid_profile.export.cad.step import StepExporter as StepExporter
from cycloid_profile.export.cad.step import parts_of as parts_of
from cycloid_profile.export.cad.step import stage_to_build123d as stage_to_build123d
from cycloid_profile.export.cad.step import to_build123d as to_build123d
