"""Keys of the files for CAD and printing."""

from __future__ import annotations

from typing import Annotated, Literal

from cycloid_profile.spec.table import Table, key


class StepSpec(Table, frozen=True):
    """STEP files of the disc and of the whole stage."""

    schema: Annotated[Literal["AP214", "AP242"], key("Application protocol of STEP files.", "")] = "AP214"
    degree: Annotated[
        Literal[3, 5], key("Degree of the tooth's splines: 5, or 3 for readers that take no more.", "give 3 or 5")
    ] = 5


class PrintSpec(Table, frozen=True):
    """Meshes for 3D printers."""

    chord_um: Annotated[
        float, key("Largest distance of the mesh's chords from the tooth [µm].", "give 1 to 50", ge=0.1, le=1000)
    ] = 5.0
    flank_offset_um: Annotated[
        float,
        key(
            "Taken off the tooth all round, for what a printer puts on too much [µm].",
            "give an amount in µm, positive removes material",
            ge=-1e4,
            le=1e4,
        ),
    ] = 0.0
