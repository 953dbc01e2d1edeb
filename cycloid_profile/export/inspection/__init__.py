"""Inspection plan of the finished disc and its DMIS program."""

from cycloid_profile.export.inspection.dmis import DmisExporter as DmisExporter
from cycloid_profile.export.inspection.dmis import read_nominals as read_nominals
from cycloid_profile.export.inspection.plan import Check as Check
from cycloid_profile.export.inspection.plan import InspectionPlan as InspectionPlan
from cycloid_profile.export.inspection.plan import inspection_plan as inspection_plan
from cycloid_profile.export.inspection.plan import plan_rows as plan_rows
