"""``cycloid-profile new``: a spec file from a ratio, with the rule behind each proposed value."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from cycloid_profile.cli.output._encoding import ascii_unless_unicode, said
from cycloid_profile.cli.output._options import Force, Json, Quiet, print_written_spec, protection_of, write_spec_file
from cycloid_profile.cli.output._terminal import printed_as_json, warn

if TYPE_CHECKING:
    from cycloid_profile.design import DriveRequest

# What is asked at a terminal: the value's name, the question, and how the answer is read.
_QUESTIONS: tuple[tuple[str, str, Callable[[str], Any]], ...] = (
    ("ratio", "Ratio of the cycloid stage, lobes of the disc (such as 11)", int),
    ("outer_diameter", "Outer diameter of the housing [mm]", float),
    ("pin_diameter", "Diameter of the pins [mm]", float),
    ("material", "Material of the discs (PLA, PETG, steel, …)", str),
    ("torque_nm", "Torque of the output [N·m]", float),
)


def new(
    *,
    ratio: Annotated[
        int | None, Parameter(help="Ratio of the cycloid stage, lobes of the disc, housing fixed.")
    ] = None,
    total_ratio: Annotated[float | None, Parameter(help="Ratio with a first stage; adds crank shafts.")] = None,
    pin_diameter: Annotated[float | None, Parameter(help="Diameter of the pins [mm].")] = None,
    outer_diameter: Annotated[float | None, Parameter(help="Outer diameter of the housing [mm].")] = None,
    material: Annotated[str | None, Parameter(help="Material of the discs, such as PLA or steel.")] = None,
    torque: Annotated[float | None, Parameter(help="Rated torque of the output [N·m].")] = None,
    out: Annotated[Path | None, Parameter(help="Spec file to write, default: print it.")] = None,
    force: Force = False,
    json: Json = None,
    quiet: Quiet = False,
) -> int:
    """Propose a drive: eccentricity, width, holes, torque and clearance, each with its rule.

    Only a ratio is needed. In a terminal the command asks for what is missing.

    Example: cycloid-profile new --ratio 11 --pin-diameter 3 --outer-diameter 60 --material PLA --out my.toml
    """
    import msgspec

    from cycloid_profile.design import DriveRequest, propose

    protection = protection_of(force, json=json)
    request = DriveRequest(ratio, total_ratio, pin_diameter, outer_diameter, material, torque)
    if sys.stdin.isatty() and sys.stderr.isatty():
        request = _completed(request)
    proposal = propose(request)
    if not quiet:
        warn(*(f"advice: {one}" for one in proposal.advice))
    if out is not None:
        write_spec_file(proposal.text, out, protection)
    printed = printed_as_json({"schema": 1, **msgspec.to_builtins(proposal.spec)}, json, protection)
    if out is None:
        if not printed:
            sys.stdout.write(ascii_unless_unicode(proposal.text))
        return 0
    if not printed and not quiet:
        print_written_spec(out)
    return 0


def _completed(request: DriveRequest) -> DriveRequest:
    """The request with the answers to questions on what is missing; an empty answer takes the proposal."""
    from dataclasses import replace

    for name, question, read in _QUESTIONS:
        answered = getattr(request, name) is not None or (name == "ratio" and request.total_ratio is not None)
        while not answered:
            hint = "" if name == "ratio" else " [Enter: propose]"
            print(said(f"{question}{hint}: ", sys.stderr), end="", file=sys.stderr, flush=True)
            answer = sys.stdin.readline()
            try:
                request = replace(request, **{name: read(answer.strip().replace(",", "."))} if answer.strip() else {})
                answered = True
            except ValueError:
                print(said("Please give a number.", sys.stderr), file=sys.stderr)
    return request
