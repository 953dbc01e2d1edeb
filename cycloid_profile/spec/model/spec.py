"""The spec file as frozen values in the units of their keys; ``design`` turns them into geometry in base units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Annotated, Any

import msgspec

from cycloid_profile._display import Described
from cycloid_profile.errors import SpecError
from cycloid_profile.spec.model.checks._suggestions import shown
from cycloid_profile.spec.model.checks._table import PRINTABLE, Table, key
from cycloid_profile.spec.model.checks._validation import validated
from cycloid_profile.spec.model.drive import DiscSpec, DriveSpec
from cycloid_profile.spec.model.effects import EmpiricalSpec, is_effect_name, remedy_of_unknown_effect
from cycloid_profile.spec.model.export import ExportSpec
from cycloid_profile.spec.model.load import LoadSpec, MaterialsSpec
from cycloid_profile.spec.model.measurement import MeasurementSpec
from cycloid_profile.spec.model.modification import EffectTable, ModificationSpec
from cycloid_profile.spec.model.quality import Quality
from cycloid_profile.spec.model.tolerance import ReferenceSpec, ToleranceSpec


class Spec(Described, Table, frozen=True, kw_only=True):
    """A whole spec file."""

    name: Annotated[
        str,
        key("Name shown in pictures and reports.", "give a short name", max_length=80, pattern=PRINTABLE),
    ] = "cycloidal drive"
    quality: (
        Annotated[
            Quality,
            key(
                "How teeth, bores and pins are made: scale of the errors that diagnosis expects; absent: printed where "
                "the disc is a plastic, else ground.",
                "",
            ),
        ]
        | None
    ) = None
    drive: DriveSpec
    materials: MaterialsSpec = MaterialsSpec()
    load: LoadSpec = LoadSpec()
    modification: ModificationSpec = ModificationSpec()
    disc: DiscSpec = DiscSpec()
    export: ExportSpec = ExportSpec()
    source: ReferenceSpec = ReferenceSpec()
    tolerance: ToleranceSpec = ToleranceSpec()
    measurement: MeasurementSpec = MeasurementSpec()
    effects: Annotated[
        tuple[EffectTable, ...],
        key("Imperfections as tables `[[effects]]`, each with a `name`, see docs/effects.md.", "give [[effects]]"),
    ] = ()
    empirical: tuple[EmpiricalSpec, ...] = ()

    def __post_init__(self) -> None:
        """Convert dictionaries given for tables, and refuse effects whose name is unknown; raises ``SpecError``."""
        super().__post_init__()
        faults = list(self.further_faults({"effects": self.effects}))
        if faults:
            raise SpecError.of(faults)

    @classmethod
    def further_faults(cls, raw: Mapping[str, Any]) -> Iterable[SpecError]:
        """Effects whose name is unknown."""
        effects = raw.get("effects", ())
        for number, effect in enumerate(effects if isinstance(effects, list | tuple) else (), start=1):
            name = effect.get("name") if isinstance(effect, dict) else ""
            if isinstance(effect, dict) and not (isinstance(name, str) and is_effect_name(name)):
                what, remedy = f"effects[{number}].name", remedy_of_unknown_effect(str(name))
                yield SpecError(what, shown(name), "is not the name of an effect", remedy)

    def replace(self, key: str | Mapping[str, Any], value: Any = None) -> Spec:
        """A new spec with one key changed, ``replace("load.contact_law", "johnson")``, or several from a mapping.

        Keys are dotted paths of the spec file, values in the unit of their key, None for an absent optional key.
        Raises ``SpecError`` as reading a file does.
        """
        raw: dict[str, Any] = msgspec.to_builtins(self)
        for path, new in ({key: value} if isinstance(key, str) else key).items():
            *tables, last = path.split(".")
            place = raw
            for table in tables:
                if not isinstance(place.get(table), dict):
                    place[table] = {}
                place = place[table]
            place[last] = new
        changed: Spec = validated(raw, Spec)
        return changed

    def _key_figures(self) -> dict[str, str]:
        drive, load, modification = self.drive, self.load, self.modification
        compensation = modification.deformation_compensation
        given = "not given" if load.rated_torque_nm is None else f"{load.rated_torque_nm:g} N·m"
        return {
            "name": self.name,
            "pins, lobes": f"{drive.pins}, {drive.pins - 1}",
            "pin circle radius": f"{drive.pin_circle_radius_mm:g} mm",
            "pin radius": f"{drive.pin_radius_mm:g} mm",
            "eccentricity": f"{drive.eccentricity_mm:g} mm",
            "discs": f"{drive.discs}, face width {drive.disc_width_mm:g} mm",
            "crank shafts": "none, central eccentric" if drive.cranks is None else str(drive.cranks.count),
            "rated torque": given,
            "disc": {"rigid": "rigid", "elastic": "elastic"}.get(load.disc_body, f"from {load.disc_body_file}"),
            "contact law": load.law,
            "modification": f"equidistant {modification.equidistant_um:g} µm, radial moving "
            f"{modification.radial_moving_um:g} µm, rotation {modification.rotation_arcmin:g}′",
            "deformation compensation": {True: "from the load", False: "none"}[compensation]
            if isinstance(compensation, bool)
            else f"{compensation:g} µm",
            "effects": f"{len(self.effects)}{f', {len(self.empirical)} empirical' if self.empirical else ''}",
        }
