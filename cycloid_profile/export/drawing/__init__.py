"""Workshop drawing of the disc as DXF, SVG and PDF."""

from cycloid_profile.export.drawing.exporter import DrawingExporter as DrawingExporter
