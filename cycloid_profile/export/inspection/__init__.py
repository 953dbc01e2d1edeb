"""Inspection plan of the finished disc in DMIS and QIF, and the evaluation of a scan."""

from cycloid_profile.export.inspection.datums import AXIS as AXIS
from cycloid_profile.export.inspection.datums import DIRECTION as DIRECTION
from cycloid_profile.export.inspection.datums import FACE as FACE
from cycloid_profile.export.inspection.datums import OF_TEETH as OF_TEETH
from cycloid_profile.export.inspection.datums import CircleDatum as CircleDatum
from cycloid_profile.export.inspection.datums import DatumSystem as DatumSystem
from cycloid_profile.export.inspection.datums import KeywayDatum as KeywayDatum
from cycloid_profile.export.inspection.datums import datum_system as datum_system
from cycloid_profile.export.inspection.dmis import DmisExporter as DmisExporter
from cycloid_profile.export.inspection.dmis import read_nominals as read_nominals
from cycloid_profile.export.inspection.evaluate import FLANKS as FLANKS
from cycloid_profile.export.inspection.evaluate import CheckResult as CheckResult
from cycloid_profile.export.inspection.evaluate import Inspection as Inspection
from cycloid_profile.export.inspection.evaluate import inspect_scan as inspect_scan
from cycloid_profile.export.inspection.plan import Check as Check
from cycloid_profile.export.inspection.plan import InspectionPlan as InspectionPlan
from cycloid_profile.export.inspection.plan import inspection_plan as inspection_plan
from cycloid_profile.export.inspection.plan import plan_rows as plan_rows
from cycloid_profile.export.inspection.qif import QifExporter as QifExporter
from cycloid_profile.export.inspection.qif import qif_document as qif_document
from cycloid_profile.export.inspection.tolerances import STATED as STATED
from cycloid_profile.export.inspection.tolerances import InspectionTolerances as InspectionTolerances
from cycloid_profile.export.inspection.tolerances import Tolerance as Tolerance
from cycloid_profile.export.inspection.tolerances import inspection_tolerances as inspection_tolerances
