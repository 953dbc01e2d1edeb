"""The spec file as frozen values: every table has a file of its own with its keys, units, defaults and limits.

Keys carry their unit, so values here are in the unit of their name; ``design.from_spec`` turns them
into geometry in base units.
"""

from __future__ import annotations

from typing import Annotated, Any

from cycloid_profile.spec.disc import DiscSpec
from cycloid_profile.spec.drive import DriveSpec
from cycloid_profile.spec.export import ExportSpec
from cycloid_profile.spec.load import LoadSpec
from cycloid_profile.spec.materials import MaterialsSpec
from cycloid_profile.spec.modification import ModificationSpec
from cycloid_profile.spec.source import SourceSpec
from cycloid_profile.spec.table import Table, key
from cycloid_profile.spec.tolerance import ToleranceSpec


class Spec(Table, frozen=True, kw_only=True):
    """A whole spec file."""

    name: Annotated[
        str,
        key("Name shown in pictures and reports.", "give a short name", max_length=80, pattern=r"^[^\x00-\x1f\x7f]*$"),
    ] = "cycloidal drive"
    drive: DriveSpec
    materials: MaterialsSpec = MaterialsSpec()
    load: LoadSpec = LoadSpec()
    modification: ModificationSpec = ModificationSpec()
    disc: DiscSpec = DiscSpec()
    export: ExportSpec = ExportSpec()
    source: SourceSpec = SourceSpec()
    tolerance: ToleranceSpec = ToleranceSpec()
    effects: Annotated[
        tuple[dict[str, Any], ...],
        key("Imperfections as tables `[[effects]]`, each with a `name`, see docs/rig.md.", "give [[effects]]"),
    ] = ()
