"""Two published articles: their formulas, fifteen sensitivities, lost-motion budget and tables."""

from cycloid_profile.articles.backlash_sensitivities import FACTORS as FACTORS
from cycloid_profile.articles.backlash_sensitivities import BacklashSensitivity as BacklashSensitivity
from cycloid_profile.articles.backlash_sensitivities import sensitivities as sensitivities
from cycloid_profile.articles.finite_difference import BacklashSlope as BacklashSlope
from cycloid_profile.articles.finite_difference import DifferenceSetup as DifferenceSetup
from cycloid_profile.articles.formulas import InvolutePair as InvolutePair
from cycloid_profile.articles.lost_motion_budget import TABLE as TABLE
from cycloid_profile.articles.lost_motion_budget import TEXT as TEXT
from cycloid_profile.articles.lost_motion_budget import Budget as Budget
from cycloid_profile.articles.lost_motion_budget import BudgetPart as BudgetPart
from cycloid_profile.articles.lost_motion_budget import PartErrors as PartErrors
from cycloid_profile.articles.lost_motion_budget import budget_from_geometry as budget_from_geometry
from cycloid_profile.articles.lost_motion_budget import printed_errors as printed_errors
from cycloid_profile.articles.results import article_tables as article_tables
from cycloid_profile.articles.tables import PlainTable as PlainTable
from cycloid_profile.articles.tables import budget_remarks as budget_remarks
from cycloid_profile.articles.tables import budget_table as budget_table
from cycloid_profile.articles.tables import disc_name as disc_name
from cycloid_profile.articles.tables import formula_table as formula_table
from cycloid_profile.articles.tables import method_table as method_table
from cycloid_profile.articles.tables import published_tables as published_tables
from cycloid_profile.articles.tables import range_table as range_table
from cycloid_profile.articles.tables import sensitivity_table as sensitivity_table
