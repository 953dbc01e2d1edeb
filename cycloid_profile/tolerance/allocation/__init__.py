"""The cheapest tolerances that reach a yield."""

from cycloid_profile.tolerance.allocation.allocator import SampleSizes as SampleSizes
from cycloid_profile.tolerance.allocation.allocator import allocate as allocate
from cycloid_profile.tolerance.allocation.result import AllocatedTolerance as AllocatedTolerance
from cycloid_profile.tolerance.allocation.result import Allocation as Allocation
from cycloid_profile.tolerance.allocation.result import AllocationStatus as AllocationStatus
from cycloid_profile.tolerance.study import percent as percent
