"""Commands, reports and pictures in Chinese: no English word is left but names, units and keys."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Callable
from io import BytesIO, TextIOWrapper
from pathlib import Path

import pytest
from rich.cells import cell_len

from cycloid_profile.articles import PlainTable
from cycloid_profile.cli.main import COMMANDS, run
from cycloid_profile.cli.output._tables import fold, table_lines
from cycloid_profile.geometry import ToothProfile
from cycloid_profile.language import VARIABLE, use_language
from cycloid_profile.language._translations import Translations
from cycloid_profile.plot import _lettering, save, tooth
from tests.language.test_translations import CHINESE
from tests.report.pages import read_page
from tests.spec_texts import RV40E

SHORT = """
name = "short"
[drive]
pins = 12
pin_circle_radius_mm = 30.0
pin_radius_mm = 2.5
eccentricity_mm = 1.5
disc_width_mm = 8.0
discs = 1
[load]
rated_torque_nm = 10.0
disc_body = "rigid"
[modification]
equidistant_um = 40.0
[export]
formats = ["csv", "gcode"]
"""
OVAL = "[[effects]]\nname = 'disc_oval'\namplitude_um = 2.0\nphase_deg = 30.0\ndisc = 1\n"
# Names of drives, files, kinds, metavariables and of what a file holds; keys, options and paths are no words.
KEPT = {
    "short", "scan", "loop", "build", "COMMAND", "OPTIONS", "SPEC", "DATA", "SCANS", "SCAN",
    "NAME", "PATH", "FILE", "INT", "FLOAT", "STR",
    "CHOICE", "Schema", "shell", "inspect", "accuracy", "simulate", "compare",
    "diagnose", "correct", "tolerance", "export", "catalog", "new", "random", "sobol", "drawing", "bom", "step", "cos",
    "zh", "numpy", "roark", "convergence", "deformation", "distributions", "sensitivities",
}  # fmt: skip
WORD = re.compile(r"(?<![\w./='`\-\[{(:])[A-Za-z][a-z]+(?![\w/=.`\-:\]}]| =)")
COMMAND_LINES = re.compile(r"(?:示例|然后)：.*?(?=\n\n|\Z)|(?<=  )cycloid-profile .*", re.DOTALL)


def english_words(text: str) -> set[str]:
    """Words of prose in a text that are neither declared names nor units."""
    same = Translations.of("zh")._same
    return {word for word in WORD.findall(COMMAND_LINES.sub("", text)) if word not in KEPT and word not in same}


@pytest.fixture
def zh(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chinese by the environment; pictures in any font."""
    monkeypatch.setenv(VARIABLE, "zh")
    monkeypatch.setattr(_lettering, "chinese_font", lambda: "DejaVu Sans")


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with specs, a scan of an oval disc and a loop."""
    folder = tmp_path_factory.mktemp("bench")
    (folder / "short.toml").write_text(SHORT, encoding="utf-8")
    (folder / "mine.toml").write_text(RV40E, encoding="utf-8")
    (folder / "oval.toml").write_text(RV40E + OVAL, encoding="utf-8")
    words = ["simulate", str(folder / "oval.toml"), "--noise", "0.3", "--seed", "1", "-q"]
    assert run([*words, "--kind", "profile_scan", "--points", "900", "--out", str(folder / "scan.csv")]) == 0
    words = ["simulate", str(folder / "mine.toml"), "--noise", "0.004", "-q", "--points", "60"]
    assert run([*words, "--kind", "hysteresis", "--out", str(folder / "loop.csv")]) == 0
    return folder


@pytest.mark.usefixtures("zh")
@pytest.mark.parametrize(
    ("words", "page"),
    [
        (["catalog"], None),
        (["new", "--ratio", "11", "--out", "{out}/new.toml"], None),
        (["build", "{bench}/short.toml", "--out", "{out}/build"], "build/report.html"),
        (["export", "{bench}/short.toml", "--list"], None),
        (["simulate", "{bench}/mine.toml", "--kind", "profile_scan", "--points", "900", "--out", "{out}/s.csv"], None),
        (["compare", "{bench}/mine.toml", "{bench}/scan.csv", "{bench}/loop.csv", "--out", "{out}"], None),
        (["inspect", "{bench}/mine.toml", "{bench}/scan.csv", "--out", "{out}"], "inspection.html"),
        (["diagnose", "{bench}/mine.toml", "{bench}/scan.csv", "--out", "{out}"], "report.html"),
        pytest.param(
            ["correct", "{bench}/mine.toml", "{bench}/scan.csv", "--out", "{out}"],
            "correction.html",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            ["tolerance", "{bench}/mine.toml", "--samples", "200", "--loaded-samples", "20", "--out", "{out}"],
            None,
            marks=pytest.mark.slow,
        ),
        pytest.param(["diagnose", "{bench}/mine.toml", "--plan", "--out", "{out}"], None, marks=pytest.mark.slow),
    ],
    ids=lambda words: words[0] if isinstance(words, list) else "",
)
def test_no_english_is_left(
    bench: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], page: str | None
) -> None:
    run([word.format(bench=bench, out=tmp_path) for word in words])
    printed = capsys.readouterr()
    assert CHINESE.search(printed.out)
    assert english_words(printed.out) == set()
    assert english_words(printed.err) == set()
    if page is not None:
        text = (tmp_path / page).read_text(encoding="utf-8")
        assert '<html lang="zh">' in text
        read = read_page(tmp_path / page)
        assert english_words(read.text) == set()
        assert read.explained
        assert all(map(CHINESE.search, read.explained.values()))
        drawn = " ".join(re.findall(r"<text[^>]*>([^<]*)<", text))
        assert english_words(html.unescape(drawn)) == set()


@pytest.mark.usefixtures("zh")
@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_help_is_chinese(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    run([*filter(None, [command]), "--help"])
    shown = capsys.readouterr().out
    assert "用法：cycloid-profile" in shown
    assert english_words(shown) == set()


@pytest.mark.parametrize("option", [["--language", "zh"], ["--language=zh"]])
def test_the_option_counts_anywhere_and_more_than_the_environment(
    option: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, "en")
    for words in ([*option, "catalog"], ["catalog", *option]):
        assert run(words) == 0
        assert "针齿中心圆半径 [mm]" in capsys.readouterr().out
    assert run(["catalog"]) == 0
    assert "pin circle radius [mm]" in capsys.readouterr().out


def test_the_locale_chooses_no_language(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("LANG", "LC_ALL", "LANGUAGE"):
        monkeypatch.setenv(name, "zh_CN.UTF-8")
    assert run(["catalog"]) == 0
    assert not CHINESE.search(capsys.readouterr().out)


def test_an_unknown_language_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["catalog", "--language", "xx"]) == 2
    assert capsys.readouterr().err == "cycloid-profile: language 'xx' has no translations: choose en or zh\n"


@pytest.mark.usefixtures("zh")
@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ('pins = "many"', 'drive.pins = "many" 必须是 整数 类型，而不是 文本：请给出 3 至 1000 个针齿'),
        ("pinns = 12", "drive.pinns = 12 不是规格文件的键：是否指 drive.pins？"),
        ("eccentricity_mm = 2.6", None),
    ],
)
def test_faults_of_a_spec_are_chinese(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], change: str, sentence: str | None
) -> None:
    key = change.split(" ")[0]
    text = re.sub(rf"^{'pins' if key == 'pinns' else key} = .*$", change, SHORT, flags=re.MULTILINE)
    (tmp_path / "bad.toml").write_text(text, encoding="utf-8")
    assert run(["accuracy", str(tmp_path / "bad.toml"), "--out", str(tmp_path)]) in (1, 2)
    shown = capsys.readouterr().err.splitlines()[-1]
    assert (
        shown == f"cycloid-profile: {sentence}" if sentence else english_words(shown) <= {"pin_circle_radius", "pins"}
    )


@pytest.mark.slow
@pytest.mark.usefixtures("zh")
def test_json_stays_english(bench: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["inspect", str(bench / "mine.toml"), str(bench / "scan.csv"), "-q", "--json", "--out", str(tmp_path)]
    run(words)
    chinese = json.loads(capsys.readouterr().out)
    run([*words, "--language", "en"])
    assert json.loads(capsys.readouterr().out) == chinese
    assert CHINESE.search(json.dumps(chinese, ensure_ascii=False)) is None


def test_an_encoding_without_chinese_letters_gets_english(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for encoding, chinese in (("ascii", False), ("cp1252", False), ("gbk", True), ("utf-8", True)):
        stream = TextIOWrapper(BytesIO(), encoding=encoding)
        monkeypatch.setattr("sys.stdout", stream)
        run(["catalog", "--language", "zh"])
        stream.flush()
        shown = stream.buffer.getvalue().decode(encoding)
        assert bool(CHINESE.search(shown)) is chinese, encoding
        assert "?" not in shown


def test_signs_fold_in_cells_and_no_line_begins_with_a_mark() -> None:
    text = "未校核：请给出 drive.pin_seat.span_mm（整槽支承取 0），再写出全部文件、图片和报告。"
    for width in range(24, 60):
        lines = fold(text, width)
        assert "".join(lines).replace(" ", "") == text.replace(" ", "")
        assert max(map(cell_len, lines)) <= width
        assert not any(line[0] in "，。；：、）" for line in lines)
    table = PlainTable("", ("项目", "易混淆于"), (("齿廓偏差", text), ("径向跳动", "–")))
    assert max(map(cell_len, table_lines(table, 60))) <= 60


@pytest.fixture
def lettered(theoretical: ToothProfile, tmp_path: Path) -> Callable[[], str]:
    """SVG of a picture, saved in Chinese."""

    def saved() -> str:
        with use_language("zh"):
            _, svg = save(tooth(theoretical, name="RV-40E"), tmp_path, "tooth")
        return svg.read_text(encoding="utf-8")

    return saved


def test_a_picture_names_a_font_with_the_letters(lettered: Callable[[], str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_lettering, "chinese_font", lambda: "Noto Sans CJK SC")
    shown = lettered()
    assert CHINESE.search(shown)
    assert "Noto Sans CJK SC" in shown


def test_without_a_font_pictures_stay_english_and_one_sentence_says_so(
    lettered: Callable[[], str], monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(_lettering, "FONTS", ())
    _lettering.chinese_font.cache_clear()
    assert not any(CHINESE.search(lettered()) for _ in range(2))
    _lettering.chinese_font.cache_clear()
    assert [record.getMessage() for record in caplog.records if "Noto Sans CJK" in record.getMessage()] == [
        "图片保持英文：本机没有含中文的字体；请安装 Noto Sans CJK"
    ]
