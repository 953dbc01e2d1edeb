"""Words and units in headers of measured files, and the quantity that a column name means."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from cycloid_profile.units import ARCMIN, ARCSEC, DEGREE, NEWTON_METRE, UM

LENGTH, ANGLE, TORQUE = "length", "angle", "torque"
_INCH = 25.4
_POUND_INCH = 112.984829  # N·mm
# Size in base units (mm, rad, N·mm) of a unit, by its spelling in small letters without blanks, dots and underscores.
UNITS: dict[str, dict[str, float]] = {
    LENGTH: {
        **dict.fromkeys(("mm", "millimeter", "millimetre", "millimeters", "毫米"), 1.0),
        **dict.fromkeys(("um", "micron", "microns", "micrometer", "micrometre", "mikrometer", "微米"), UM),
        **dict.fromkeys(("m", "meter", "metre", "米"), 1e3),
        **dict.fromkeys(("cm", "厘米"), 10.0),
        "nm": 1e-6,
        **dict.fromkeys(("in", "inch", "inches", "zoll", '"', "英寸"), _INCH),
        **dict.fromkeys(("mil", "thou"), 1e-3 * _INCH),
    },
    ANGLE: {
        **dict.fromkeys(("rad", "radian", "radians", "弧度"), 1.0),
        "mrad": 1e-3,
        "urad": 1e-6,
        **dict.fromkeys(("deg", "degree", "degrees", "°", "grad", "度"), DEGREE),
        **dict.fromkeys(("arcmin", "arcmins", "arcminute", "arcminutes", "amin", "winkelminuten"), ARCMIN),
        **dict.fromkeys(("bogenminuten", "'", "′", "分", "角分"), ARCMIN),
        **dict.fromkeys(("arcsec", "arcsecs", "arcsecond", "arcseconds", "asec", "winkelsekunden"), ARCSEC),
        **dict.fromkeys(("bogensekunden", '"', "″", "''", "秒", "角秒"), ARCSEC),
        "mdeg": 1e-3 * DEGREE,
        "gon": math.pi / 200.0,
        **dict.fromkeys(("rev", "turn", "turns"), 2.0 * math.pi),
    },
    TORQUE: {
        **dict.fromkeys(("nm", "newtonmeter", "newtonmetre", "牛米", "牛顿米"), NEWTON_METRE),
        **dict.fromkeys(("nmm", "newtonmillimeter"), 1.0),
        **dict.fromkeys(("mnm",), 1.0),
        **dict.fromkeys(("ncm",), 10.0),
        **dict.fromkeys(("knm",), 1e3 * NEWTON_METRE),
        **dict.fromkeys(("lbin", "inlb", "lbfin", "inlbf", "inlbs"), _POUND_INCH),
        **dict.fromkeys(("lbft", "ftlb", "lbfft", "ftlbf", "ftlbs"), 12.0 * _POUND_INCH),
        **dict.fromkeys(("kgfcm", "kgcm"), 98.0665),
        **dict.fromkeys(("kgfm", "kgm"), 9806.65),
    },
}  # fmt: skip
_PLAIN = frozenset({"-", "1", "-/-"})  # units of a plain number
_OTHER_UNITS = frozenset(
    {"s", "ms", "min", "h", "v", "mv", "n", "kn", "°c", "c", "k", "%", "hz", "rpm", "1/min", "bar"}
)
_SAME_SIGN = str.maketrans({"µ": "u", "μ": "u", "º": "°", "˚": "°", "’": "'", "´": "'", "”": '"', "“": '"'})
_BRACKETED = re.compile(r"^(.*?)\s*(?:\[\s*([^\]]*)\s*\]|\(\s*([^)]*)\s*\)|【\s*([^】]*)\s*】|（\s*([^）]*)\s*）)\s*$")
_AFTER_WORD = re.compile(r"^(.*?)(?:\s+in\s+|\s*/\s*|[\s_]+|(?<=\w)(?=°))([^\s_/]+)$", re.IGNORECASE)
_AFTER_AXIS = re.compile(r"^([xyz])(mm|um|µm|inch)$", re.IGNORECASE)

# Canonical words by their spellings. Long ones and Chinese ones are also found inside compounds.
_SPELLINGS: dict[str, tuple[str, ...]] = {
    "torque": ("torque", "drehmoment", "moment", "couple", "coppia", "转矩", "扭矩", "力矩", "轉矩",
        "トルク"),
    "polar": ("polar", "polarwinkel", "azimuth", "极角", "極角", "polaire"),
    "angle": ("angle", "winkel", "verdrehung", "verdrehwinkel", "twist", "rotation", "phi", "φ", "ϕ", "theta", "θ",
        "alpha", "α", "angolo", "转角", "角度", "角位移", "位置角", "扭转角", "扭角",
        "轉角", "扭轉角", "ねじれ角"),
    "output": ("output", "abtrieb", "abtriebs", "sortie", "uscita", "输出轴", "输出端", "输出"),
    "input": ("input", "antrieb", "antriebs", "motor", "entrée", "输入轴", "输入端", "输入"),
    "error": ("error", "fehler", "drehfehler", "erreur", "errore", "误差", "te", "err", "drehwegabweichung",
        "übertragungsfehler"),
    "transmission": ("transmission", "übertragungs", "kinematic", "传动"),
    "lost_motion": ("lost motion", "lostmotion", "umkehrspanne", "verlustdrehwinkel", "空程", "回差"),
    "deviation": ("deviation", "dev", "abweichung", "abw", "écart", "ecart", "delta", "偏差"),
    "radius": ("radius", "r", "rho", "ρ", "rayon", "raggio", "半径", "向径", "极径", "極徑"),
    "nominal": ("nominal", "nom", "soll", "sollwert", "theo", "theoretical", "cad", "target", "理论", "名义", "公称"),
    "actual": ("actual", "act", "measured", "meas", "ist", "istwert", "gemessen", "mess", "messwert", "mesuré",
        "实测", "实际", "测量"),
    "normal": ("normal", "normale", "法向", "法向量"),
    "x": ("x",), "y": ("y",), "z": ("z",),
    "normal_x": ("nx", "i"), "normal_y": ("ny", "j"),
    "": ("coordinate", "coord", "koordinate", "position", "pos", "value", "wert", "point", "punkt", "axis", "achse",
         "of", "the", "in", "at", "probe", "sensor", "encoder", "channel", "kanal", "mean", "avg", "坐标", "值", "点",
         "signal", "disc", "shaft", "welle", "applied", "load", "last", "tooth", "flank", "profile", "pose",
         "test", "prüf", "belastung", "belastungs", "charge", "负载", "载荷", "测试", "试验", "加载"),
}  # fmt: skip
_WORD_OF = {spelling: word for word, spellings in _SPELLINGS.items() for spelling in spellings}
_INSIDE = sorted((s for s in _WORD_OF if len(s) > 4 or not s.isascii()), key=len, reverse=True)

# Quantity of a column by its words; "actual" is what a column holds unless it says otherwise.
_ROLES: dict[frozenset[str], str] = {
    frozenset(words.split()): role
    for role, variants in {
        "x": ("x",), "y": ("y",), "nominal_x": ("nominal x",), "nominal_y": ("nominal y",),
        "normal_x": ("normal_x", "normal x"), "normal_y": ("normal_y", "normal y"),
        "deviation": ("deviation", "deviation normal"),
        "radius": ("radius", "radius polar"), "polar_angle": ("polar", "polar angle"),
        "torque": ("torque", "torque output"), "angle": ("angle",), "output_angle": ("angle output",),
        "error": ("error", "transmission error", "error angle", "transmission error angle", "error output"),
        "lost_motion": ("lost_motion", "lost_motion angle"),
    }.items()
    for words in variants
}  # fmt: skip
DIMENSIONS = {
    **dict.fromkeys(("x", "y", "nominal_x", "nominal_y", "deviation", "radius"), LENGTH),
    **dict.fromkeys(("polar_angle", "angle", "output_angle", "error", "lost_motion"), ANGLE),
    "torque": TORQUE,
    "normal_x": "",
    "normal_y": "",
}


class HeaderWord(NamedTuple):
    """A column name apart from its unit, which is "" where the header states none; ``role``, its quantity or ""."""

    name: str
    unit: str
    role: str


def unit_size(unit: str, dimension: str) -> float | None:
    """Size of a unit in base units, None if it is not one of that dimension."""
    return UNITS.get(dimension, {}).get(_spelling(unit))


def is_unit(text: str) -> bool:
    """Whether a cell is nothing but a unit, in brackets or not."""
    bare = text.strip().strip("[]()（）【】").strip()
    return bare in _PLAIN or bare.lower() in _OTHER_UNITS or _known(bare)


def interpret(name: str, unit: str = "") -> HeaderWord:
    """Name, unit and quantity of a column from its header, and from the cell of a row of units."""
    base, inside = name.strip().rstrip("_"), unit.strip().strip("[]()（）【】").strip()
    if not inside:
        base, inside = _unit_in(base)
    words = words_of(base)
    if inside in _PLAIN:
        inside = ""
    if unit_size(inside, ANGLE) is not None and "deviation" in words and not words & {"x", "y"}:
        words = (words - {"deviation", "normal"}) | {"error"}
    role = _ROLES.get(frozenset(words), "")
    if role and _known(inside) and unit_size(inside, DIMENSIONS[role]) is None:
        role = ""
    if not role and unit_size(inside, TORQUE) is not None and not words & {"input", "nominal"} and inside != "nm":
        role = "torque"
    return HeaderWord(base, inside, role)


def _unit_in(name: str) -> tuple[str, str]:
    bracketed = _BRACKETED.match(name)
    if bracketed:
        return bracketed[1] or name, next((group for group in bracketed.groups()[1:] if group), "").strip()
    after = _AFTER_WORD.match(name) or _AFTER_AXIS.match(name)
    if after and _known(after[2]) and after[1]:
        return after[1], after[2]
    return name, ""


def _known(unit: str) -> bool:
    return any(_spelling(unit) in sizes for sizes in UNITS.values())


def _spelling(unit: str) -> str:
    return re.sub(r"[\s.·⋅*_\-^]", "", unit.translate(_SAME_SIGN).lower())


def words_of(name: str) -> set[str]:
    """Canonical words of a name; unknown ones as they are."""
    text = re.sub(r"(?<=[a-zäöü])(?=[A-Z])|(?<=[A-Za-z])(?=\d)", " ", name)
    text = re.sub(r"[_\W]+", " ", text.lower()).strip()
    for spelling in _INSIDE:
        if spelling in text:
            text = text.replace(spelling, f" {_WORD_OF[spelling] or '.'} ")
    words = [_WORD_OF.get(word, word) for word in text.split() if word != "."]
    words = [part for word in words for part in _parts(word)]
    return {word for word in words if word and word != "actual"}


def _parts(word: str) -> list[str]:
    """An axis and its qualifier written as one word, such as ``xnom`` or ``istx``; else the word."""
    for axis in "xy":
        for rest in (word.removeprefix(axis), word.removesuffix(axis)):
            if rest != word and _WORD_OF.get(rest) in {"nominal", "actual"}:
                return [axis, _WORD_OF[rest]]
    return [word]
