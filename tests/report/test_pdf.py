"""Reports as PDF, read back by pypdf; skipped where WeasyPrint or its system library is missing."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

from cycloid_profile.cli.main import run
from cycloid_profile.errors import ExportError
from cycloid_profile.report import require_pdf, write_pdf
from tests.report.pages import read_page

MEASURED = Path(__file__).parents[2] / "examples" / "measured"
COMMAND = ["inspect", str(MEASURED / "rv40e.toml"), str(MEASURED / "scan.csv"), "-q", "--pdf"]
A4 = (595.28, 841.89)  # points
pypdf = pytest.importorskip("pypdf")


@pytest.fixture(scope="module")
def inspected(tmp_path_factory: pytest.TempPathFactory) -> Path:
    try:
        require_pdf()
    except ExportError as error:
        pytest.skip(str(error))
    folder = tmp_path_factory.mktemp("pdf")
    assert run([*COMMAND, "--out", str(folder)]) == 0
    return folder


def fonts(reader: Any) -> list[Any]:
    """Descriptors of all fonts of a document."""
    found = {}
    for page in reader.pages:
        for one in page["/Resources"]["/Font"].values():
            (descendant,) = one.get_object()["/DescendantFonts"]
            descriptor = descendant.get_object()["/FontDescriptor"]
            found[descriptor["/FontName"]] = descriptor
    return list(found.values())


@pytest.mark.slow
def test_the_pdf_has_the_content_of_the_page_on_a4(inspected: Path) -> None:
    reader = pypdf.PdfReader(inspected / "inspection.pdf")
    page = read_page(inspected / "inspection.html")
    text = " ".join(" ".join(one.extract_text() for one in reader.pages).split())
    assert page.verdict in text
    for heading in (words for tag, words in page.texts if tag == "h2"):
        assert heading in text
    assert "F_α" in text
    for one in reader.pages:
        assert (float(one.mediabox.width), float(one.mediabox.height)) == pytest.approx(A4, abs=0.01)


@pytest.mark.slow
def test_fonts_are_embedded_and_ours(inspected: Path) -> None:
    found = fonts(pypdf.PdfReader(inspected / "inspection.pdf"))
    assert found
    for one in found:
        assert {"/FontFile", "/FontFile2", "/FontFile3"} & set(one)
        assert "DejaVu-Sans" in one["/FontName"]


@pytest.mark.slow
def test_the_same_page_makes_the_same_bytes(inspected: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    write_pdf((inspected / "inspection.html").read_text(encoding="utf-8"), tmp_path / "again.pdf")
    assert (tmp_path / "again.pdf").read_bytes() == (inspected / "inspection.pdf").read_bytes()


@pytest.mark.parametrize("fault", [ImportError("no module"), OSError("cannot load library 'libpango-1.0-0'")])
def test_a_missing_library_is_one_sentence_before_any_work(
    fault: Exception, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    class Missing:
        def find_spec(self, name: str, *_: object) -> None:
            if name == "weasyprint":
                raise fault

    monkeypatch.delitem(sys.modules, "weasyprint", raising=False)
    monkeypatch.setattr(sys, "meta_path", [Missing(), *sys.meta_path])
    out = tmp_path / "out"
    # A spec that does not exist: the library is looked for first.
    assert run(["build", str(tmp_path / "none.toml"), "--pdf", "--out", str(out)]) == 2
    (sentence,) = capsys.readouterr().err.splitlines()
    assert sentence.startswith("cycloid-profile: --pdf needs")
    assert "install" in sentence
    assert not out.exists()
