"""Terms of the reports: found in a page, explained on hover, and listed at its end."""

from __future__ import annotations

import re
from functools import cache
from typing import NamedTuple

from cycloid_profile.language import ENGLISH, chosen_language, translated


class Term(NamedTuple):
    """A term of the glossary, its meaning in plain words, and the pattern of the words that a page uses for it."""

    name: str
    meaning: str
    pattern: str


# Names and meanings are those of docs/glossary.md; a test compares them.
TERMS = (
    Term("lobe", "one tooth of the disc; one less than the pins", "(?i:lobes?)"),
    Term("flank", "half of a lobe; the positive flank carries positive torque", "(?i:flanks?)"),
    Term(
        "short-width ratio K1",
        "eccentricity times number of pins over pin circle radius, between 0 and 1; near 1 the tooth is pointed",
        r"(?i:short-width ratio)(?: K1)?|K1",
    ),
    Term("phase", "position on the tooth: 0 at a root, ±180° at a tip", "ψ"),
    Term("critical phase", "phase of the longest lever, arccos K1", "ψ0"),
    Term("undercut", "loop of the tooth curve when the pin is thicker than the limit", "(?i:undercut)"),
    Term(
        "equidistant modification",
        "same removal along the normal everywhere: a larger generating pin",
        "(?i:equidistant(?: modification| error)?)|equidistant_um|equidistant_error",
    ),
    Term(
        "radial-moving modification",
        "removal by a smaller generating pin circle",
        "(?i:radial[- ]moving(?: modification| error)?)|radial_moving_um|radial_moving_error",
    ),
    Term(
        "radial clearance",
        "gap at root and tip: equidistant plus radial-moving modification",
        "(?i:radial clearance)(?! of a)",
    ),
    Term(
        "compensation",
        "contact deformation added back to the flanks: less backlash, same radial clearance",
        "(?i:deformation compensation)",
    ),
    Term("conventional, compensated", "the tooth before and after compensation", "(?i:conventional|compensated)"),
    Term("δmax, approach", "elastic approach of pin and tooth; largest value", "δmax"),
    Term("classical scheme", "published iteration with pins at multiples of one pitch", "(?i:classical)"),
    Term("equilibrium", "moment balance of one disc, or force balance of the whole stage", "(?i:equilibrium)"),
    Term("loaded pins", "pins with a contact force above zero", "(?i:loaded pins)"),
    Term("peak pressure", "largest Hertzian pressure of a contact", "(?i:peak pressure)"),
    Term("basic rating life", "life that 90 % of the bearings reach", "(?i:basic rating life(?: L10)?)|L10"),
    Term(
        "dynamic load rating",
        "constant load under which 90 % of the bearings reach a million turns",
        "(?i:dynamic load rating)",
    ),
    Term("equivalent load", "constant load with the same fatigue as the load over a turn", "(?i:equivalent load)"),
    Term(
        "viscosity ratio",
        "viscosity of the oil over the one that parts the surfaces",
        "(?i:viscosity ratio(?: κ)?)",
    ),
    Term("backlash", "free rotation at zero torque, from geometry alone", "(?i:backlash)"),
    Term(
        "crank held, input held",
        "backlash with fixed disc axis, and with fixed sun; the second is a little smaller",
        "crank held|input held",
    ),
    Term(
        "lost motion",
        "angle between +3 % and −3 % torque on the centre line of the hysteresis loop",
        "(?i:lost motion)",
    ),
    Term("torsional rigidity", "slope of the loading branch from 50 to 100 % torque", "(?i:torsional rigidity)"),
    Term(
        "transmission error",
        "actual minus ideal output angle over one turn, peak to peak",
        "(?i:transmission error)",
    ),
    Term("twist", "rotation of the output beyond first touch", "(?i:twist)"),
    Term("mesh cycle", "crank rotation by one pin pitch; the meshing then repeats", "(?i:mesh cycle)"),
    Term("arc minute, arc second", "a sixtieth of a degree, and a sixtieth of an arc minute", "′|″"),
    Term("order", "component of a curve with that many periods in one turn of the output", "(?i:order(?= \\d))"),
    Term("profile scan", "points of the tooth from a measuring machine", "(?i:profile scan)"),
    Term("datum", "origin of a scan: bore axis, or free", "(?i:datum)"),
    Term("noise", "standard deviation of repeated readings", "(?i:noise)"),
    Term("root mean square", "typical size of values that scatter about zero", "(?i:rms|root mean squares?)"),
    Term("profile deviation", "largest deviation of a point along the normal of the flank, in the datum", "F_α"),
    Term("single pitch", "largest deviation of a flank from the same flank of the lobe before", "f_p"),
    Term(
        "cumulative pitch",
        "largest minus least position of a flank, the worse of left and right flanks",
        "F_p",
    ),
    Term("runout", "largest minus least radial position of the tooth spaces about the bore", "F_r"),
    Term("residual", "measured minus predicted, after registration", "(?i:residual)"),
    Term("p-value", "probability of such a residual by noise alone", "p(?= =| below)"),
    Term("evidence", "logarithm of how much more likely the data are with the effect", "ln B|(?i:evidence)"),
    Term("held-out rows", "rows that took no part in the fit and check it", "(?i:held[- ]out)"),
    Term("χ² per row", "mean square of the residual over that of the noise; 1 for pure noise", "χ² per row"),
    Term("detection limit", "smallest effect that the files would show", "(?i:detectable)"),
    Term("stock", "material that a grinding step leaves", "(?i:stock)"),
    Term("yield", "share of simulated reducers that keep all limits", "(?i:yield)"),
    Term("percentile", "value that a stated share of reducers stays below", "(?i:percentile)"),
    Term("sensitivity", "change of a quantity per unit of an error", "(?i:sensitivit(?:y|ies))"),
    Term("process capability", "tolerance over three standard deviations", "Cp"),
    Term("Sobol index", "share of a variance that one error causes", "Sobol ind(?:ex|ices)"),
    Term(
        "batch share",
        "part of a variance that all reducers of a batch have in common",
        "(?i:share of a batch|batch share)",
    ),
    Term("allocation", "the cheapest tolerances that reach a yield", "(?i:allocation)"),
)

# Texts of other scripts have no blanks between words: only a letter of the alphabet makes a pattern part of a word.
_LETTER = r"[A-Za-z0-9_]"
# Text of these elements is left as it is, the verdict among them, and so is every tag.
_KEPT = re.compile(r"(<(?P<kept>svg|style|title|h1|strong|a|abbr|code)\b.*?</(?P=kept)>|<[^>]*>)", re.DOTALL)


def explained(page: str) -> tuple[str, list[Term]]:
    """A page in the chosen language with each term marked where a section first uses it, and the terms found, in the
    order of ``TERMS``.
    """
    terms, pattern = _terms_of(chosen_language())
    used: set[int] = set()
    fresh: set[int] = set()

    def marked(match: re.Match[str]) -> str:
        number = int(str(match.lastgroup)[1:])
        if number in fresh:
            return match[0]
        fresh.add(number)
        used.add(number)
        return f'<abbr title="{terms[number].meaning}">{match[0]}</abbr>'

    parts, at = [], 0
    for kept in _KEPT.finditer(page):
        parts += [pattern.sub(marked, page[at : kept.start()]), kept[0]]
        at = kept.end()
        if kept[0].startswith("<h2"):
            fresh.clear()
    parts.append(pattern.sub(marked, page[at:]))
    return "".join(parts), [terms[i] for i in sorted(used)]


@cache
def _terms_of(language: str) -> tuple[tuple[Term, ...], re.Pattern[str]]:
    """The terms in the chosen ``language``, and the pattern that finds them."""
    if language == ENGLISH:
        groups = "|".join(f"(?P<t{i}>{one.pattern})" for i, one in enumerate(TERMS))
        return TERMS, re.compile(rf"(?<!\w)(?:{groups})(?!\w)")
    terms = tuple(Term(translated(one.name), translated(one.meaning), _pattern(one)) for one in TERMS)
    return terms, re.compile("|".join(f"(?P<t{i}>{one.pattern})" for i, one in enumerate(terms)))


def _pattern(term: Term) -> str:
    """Words of a translated name, and the symbols and keys of the English pattern."""
    words = [re.escape(word) for word in translated(term.name).split("、") if not word.isascii()]
    return "|".join([*words, f"(?<!{_LETTER})(?:{term.pattern})(?!{_LETTER})"])
