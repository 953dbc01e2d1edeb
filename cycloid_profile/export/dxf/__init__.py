"""DXF R2010 of the disc: splines or tangent arcs, openings and reference lines."""

from cycloid_profile.export.dxf.document import LAYERS as LAYERS
from cycloid_profile.export.dxf.document import Layer as Layer
from cycloid_profile.export.dxf.document import draw_contour as draw_contour
from cycloid_profile.export.dxf.document import new_document as new_document
from cycloid_profile.export.dxf.document import repeatable_bytes as repeatable_bytes
from cycloid_profile.export.dxf.document import save as save
from cycloid_profile.export.dxf.document import write_polyline as write_polyline
from cycloid_profile.export.dxf.part_sections import PartDxfExporter as PartDxfExporter
from cycloid_profile.export.dxf.tooth import ArcDxfExporter as ArcDxfExporter
from cycloid_profile.export.dxf.tooth import DxfExporter as DxfExporter
from cycloid_profile.export.dxf.tooth import OffsetDxfExporter as OffsetDxfExporter
from cycloid_profile.export.dxf.tooth import add_spline as add_spline
from cycloid_profile.export.dxf.tooth import cutter_offset as cutter_offset
from cycloid_profile.export.dxf.tooth import read_dxf_arcs as read_dxf_arcs
from cycloid_profile.export.dxf.tooth import read_dxf_profile as read_dxf_profile
from cycloid_profile.export.dxf.tooth import read_dxf_splines as read_dxf_splines
