"""Elastic constants and densities of materials by name, with their sources."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from cycloid_profile.errors import SpecError, did_you_mean
from cycloid_profile.spec.model.quality import Quality


@dataclass(frozen=True)
class NamedMaterial:
    """Young's modulus [GPa], Poisson's ratio, density [kg/m³], and how parts of it are usually made."""

    name: str
    youngs_modulus_gpa: float
    poisson_ratio: float
    density_kg_per_m3: float
    quality: Quality
    source: str


_DOWLING = "Dowling, Mechanical Behavior of Materials, Table 5.2"
_PRINTED = "printed specimens, in the plane of the layers"
MATERIALS = (
    NamedMaterial("steel", 206.0, 0.3, 7850.0, "ground", "bearing steel, as in the published drives of the catalogue"),
    NamedMaterial(
        "stainless steel", 200.0, 0.29, 7900.0, "ground", "austenitic, handbook value; 193 to 215 GPa are found"
    ),
    NamedMaterial("ductile iron", 170.0, 0.28, 7100.0, "machined", "EN 1563, 169 to 176 GPa and 0.275"),
    NamedMaterial("brass", 101.0, 0.35, 8530.0, "machined", f"{_DOWLING}: CuZn30"),
    NamedMaterial("bronze", 103.0, 0.34, 8800.0, "machined", "cold rolled, handbook value; 96 to 120 GPa are found"),
    NamedMaterial("aluminium", 70.3, 0.345, 2700.0, "machined", _DOWLING),
    NamedMaterial("PLA", 3.0, 0.36, 1240.0, "printed", f"{_PRINTED}: 2.0 to 4 GPa by make; Poisson's ratio assumed"),
    NamedMaterial(
        "PETG", 2.0, 0.38, 1270.0, "printed", f"{_PRINTED}: 2 to 3 GPa by make; Poisson's ratio of polycarbonate"
    ),
    NamedMaterial("ABS", 2.4, 0.35, 1050.0, "printed", f"{_DOWLING}, moulded; printed parts reach less"),
    NamedMaterial("PC", 2.4, 0.38, 1200.0, "printed", f"{_DOWLING}, moulded; printed parts reach less"),
    NamedMaterial("PA66", 2.7, 0.41, 1140.0, "machined", f"{_DOWLING}, dry; moist parts reach half"),
    NamedMaterial("POM", 2.8, 0.35, 1410.0, "machined", "acetal, handbook value; Poisson's ratio assumed"),
)
_OTHER_NAMES = {
    "aluminum": "aluminium", "al": "aluminium", "stainless": "stainless steel", "inox": "stainless steel",
    "nodular iron": "ductile iron", "cast iron": "ductile iron", "nylon": "PA66", "polyamide": "PA66", "pa": "PA66",
    "acetal": "POM", "delrin": "POM", "polycarbonate": "PC", "polylactide": "PLA", "bearing steel": "steel",
}  # fmt: skip


def named_material(name: str) -> NamedMaterial:
    """The material of a name, in small or capital letters; raises ``SpecError`` with the nearest one."""
    known = {one.name.casefold(): one for one in MATERIALS}
    wanted = " ".join(name.replace("_", " ").replace("-", " ").casefold().split())
    wanted = _OTHER_NAMES.get(wanted, wanted).casefold()
    if wanted not in known:
        names = [one.name for one in MATERIALS]
        near = did_you_mean(wanted, known, f"known are {', '.join(names)}")
        remedy = f"{near.rstrip('?')}, or give youngs_modulus_gpa"
        raise SpecError("material", f'"{name}"', "is not in the table of materials", remedy)
    return known[wanted]


def is_like_steel(youngs_modulus_gpa: float) -> bool:
    """Whether a modulus is within 10 % of that of steel, so that a material without a name is taken for steel."""
    return abs(youngs_modulus_gpa / named_material("steel").youngs_modulus_gpa - 1.0) < 0.1


def material_values(name: str) -> dict[str, Any]:
    """Keys of a material's table in the spec file."""
    found = named_material(name)
    return {
        "youngs_modulus_gpa": found.youngs_modulus_gpa,
        "poisson_ratio": found.poisson_ratio,
        "name": found.name,
    }


def material_table() -> str:
    """Markdown table of the materials."""
    head = [
        "| material | Young's modulus [GPa] | Poisson's ratio | density [kg/m³] | made | source |",
        "|---|---|---|---|---|---|",
    ]
    rows = [
        f"| `{one.name}` | {one.youngs_modulus_gpa:g} | {one.poisson_ratio:g} | {one.density_kg_per_m3:g} "
        f"| {one.quality} | {one.source} |"
        for one in MATERIALS
    ]
    return "\n".join([*head, *rows, ""])
