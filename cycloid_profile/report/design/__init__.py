"""Report and files of a design."""

from cycloid_profile.report.design.package import build_package as build_package
from cycloid_profile.report.design.package import design_report as design_report
from cycloid_profile.report.design.package import export_package as export_package
from cycloid_profile.report.design.package import save_accuracy_plot as save_accuracy_plot
from cycloid_profile.report.design.tables import drive_table as drive_table
from cycloid_profile.report.design.tables import planned_files_table as planned_files_table
from cycloid_profile.report.design.tables import terminal_tables as terminal_tables
from cycloid_profile.report.design.tables import warnings as warnings
from cycloid_profile.report.design.tables import written_files_table as written_files_table
from cycloid_profile.report.design.text import design_meaning as design_meaning
from cycloid_profile.report.design.text import design_subject as design_subject
from cycloid_profile.report.design.text import design_verdict as design_verdict
from cycloid_profile.report.page import REPORT as REPORT
