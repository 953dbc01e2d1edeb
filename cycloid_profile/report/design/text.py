"""A design in sentences: the verdict, and what its numbers mean for the drive."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

from cycloid_profile._display import figure_text, with_unit
from cycloid_profile.design import CheckStatus
from cycloid_profile.report.page import Verdict, at_an_arm


def design_verdict(figures: Mapping[str, Any]) -> Verdict:
    """Whether the disc can work, from the checks of ``summary``."""
    if figures["failures"]:
        return Verdict("This disc cannot work as specified.", "failed")
    count = Counter(CheckStatus(check["status"]) for check in figures["checks"])
    against, missing = count[CheckStatus.ADVISED_AGAINST], count[CheckStatus.NOT_CHECKED]
    whom = " of the nominal parts" if figures["as_built"] else ""
    if against or missing:
        one = "advises" if against == 1 else "advise"
        open_ends = [f"{against} {one} against this design"] if against else []
        open_ends += [f"{missing} could not be made for want of data"] if missing else []
        return Verdict(f"No check{whom} failed, but {' and '.join(open_ends)}.", "good")
    assumed = count[CheckStatus.ESTIMATED]
    basis = f", {assumed} of them on assumed data" if assumed else ""
    return Verdict(f"All {len(figures['checks'])} checks{whom} passed{basis}.", "good")


def design_subject(figures: Mapping[str, Any], discs: int) -> str:
    """The drive in one sentence."""
    assumed = " (assumed from the size)" if figures["rated_torque_assumed"] else ""
    return (
        f"{figures['lobes']} lobes in {figures['pins']} pins, {discs} disc{'' if discs == 1 else 's'}, short-width "
        f"ratio K1 = {figure_text(figures['short_width_ratio'])}, rated torque "
        f"{figure_text(figures['rated_torque_nm'])} N·m{assumed}."
    )


def design_meaning(figures: Mapping[str, Any]) -> list[str]:
    """Compensation, backlash, twist, transmission error, life and heat, as a user of the drive meets them."""
    before, after, loaded = figures["conventional"], figures["compensated"], figures["under_load"]
    play, error, twist = after["backlash_arcmin"], after["transmission_error_arcsec"], loaded["twist_arcmin"]
    torque = figure_text(figures["rated_torque_nm"], "N·m")
    free = "the output moves so far by hand, without load" if play > 0.0 else "pins and disc overlap, the drive binds"
    sentences = [f"Backlash {_angle(play, '′')} = {at_an_arm(play)}: {free}."]
    if figures["compensation"]["applied"]:
        sentences.insert(
            0,
            f"Deformation compensation of {figure_text(figures['compensation']['delta_max_um'], 'µm')} changes the "
            f"backlash from {_angle(before['backlash_arcmin'], '′')} to {_angle(play, '′')}, at an unchanged radial "
            f"clearance of {figure_text(figures['radial_clearance_um'], 'µm')}.",
        )
    sentences.append(f"{torque} twists the output by {_angle(twist, '′')} = {at_an_arm(twist)}, beyond first touch.")
    if error is not None:
        ripple = at_an_arm(error / 60.0)
        sentences.append(f"Transmission error {_angle(error, '″')} = {ripple}: the ripple of a turn at rated torque.")
    life, losses = figures["strength"].get("crank_bearing_life_h"), figures["losses"]["likely"]
    speed = figure_text(loaded["output_speed_rpm"], "rpm")
    if life:
        sentences.append(f"After {figure_text(life, 'h', 2)} at {speed} one crank bearing in ten has failed.")
    sentences.append(f"At {speed} and rated torque, about {figure_text(losses['heat_w'], 'W', 2)} become heat.")
    return sentences


def _angle(value: float | None, sign: str) -> str:
    return "–" if value is None else with_unit(figure_text(value, digits=3), sign)
