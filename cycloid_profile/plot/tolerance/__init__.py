"""Figures of tolerance studies and budgets."""

from cycloid_profile.plot.tolerance.allocations import cost_bars as cost_bars
from cycloid_profile.plot.tolerance.allocations import limited_quantities as limited_quantities
from cycloid_profile.plot.tolerance.allocations import tolerance_bars as tolerance_bars
from cycloid_profile.plot.tolerance.budgets import budget as budget
from cycloid_profile.plot.tolerance.budgets import sensitivities as sensitivities
from cycloid_profile.plot.tolerance.studies import distributions as distributions
from cycloid_profile.plot.tolerance.studies import ranking as ranking
from cycloid_profile.plot.tolerance.studies import tornado as tornado
