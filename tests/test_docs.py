"""The documentation: generated pages are current, guides and gallery complete, links lead somewhere, YAML parses."""

from __future__ import annotations

import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import jinja2
import pytest
import yaml

from tests.script_modules import ROOT, script

DOCS = ROOT / "docs"
GUIDES = sorted((DOCS / "guides").glob("*.md"))
PAGES = sorted([*DOCS.rglob("*.md"), *ROOT.glob("*.md")])
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LARGEST_PICTURE = 150_000
NUMBER = re.compile(r"\d+(?:[.,]\d+)*(?:e-?\d+)?")


def test_generated_pages_are_current() -> None:
    made = script("docs", "make_reference").pages()
    stale = [str(path.relative_to(ROOT)) for path, text in made.items() if path.read_text(encoding="utf-8") != text]
    assert stale == [], "run python docs/make_reference.py"
    assert set((DOCS / "reference").glob("*.md")) <= set(made)


def test_every_public_name_is_found_and_described() -> None:
    rows = re.findall(
        r"^\| `(.+?)` \| (.*) \|$", "\n".join(script("docs", "make_reference").pages().values()), re.MULTILINE
    )
    assert len(rows) > 200
    assert [name for name, text in rows if text == "–"] == []


def test_gallery_shows_every_example() -> None:
    gallery = script("docs", "make_gallery")
    assert (DOCS / "gallery.md").read_text(encoding="utf-8") == gallery.page(), "run python docs/make_gallery.py"
    assert len(gallery.examples()) >= 6


@pytest.mark.parametrize("page", GUIDES, ids=lambda page: page.stem)
def test_a_guide_is_a_short_path_with_a_picture(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert 4 <= len(re.findall(r"^\$ ", text, re.MULTILINE)) <= 8
    assert len(re.findall(r"!\[", text)) == 1
    assert len(text.splitlines()) < 120


def test_the_index_lists_every_page() -> None:
    text = (DOCS / "index.md").read_text(encoding="utf-8")
    pages = (page.relative_to(DOCS).as_posix() for page in DOCS.rglob("*.md") if page.name != "index.md")
    assert [page for page in pages if f"]({page})" not in text] == []


def test_the_site_lists_every_page() -> None:
    nav = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").split("nav:\n")[1].split("markdown_extensions:")[0]
    listed = re.findall(r"[\w/-]+\.md", nav)
    assert sorted(listed) == sorted(page.relative_to(DOCS).as_posix() for page in DOCS.rglob("*.md"))


def test_guides_are_five() -> None:
    assert [page.stem for page in GUIDES] == ["bench", "grind", "measure", "print", "study"]


def test_pictures_are_small_and_used() -> None:
    text = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    for picture in (DOCS / "pictures").iterdir():
        assert picture.stat().st_size < LARGEST_PICTURE, picture.name
        assert f"pictures/{picture.name})" in text, picture.name


@pytest.mark.slow
@pytest.mark.parametrize("page", GUIDES, ids=lambda page: page.stem)
def test_commands_of_a_guide_print_what_it_shows(page: Path, tmp_path: Path) -> None:
    guides, text = script("docs", "make_guides"), page.read_text(encoding="utf-8")
    missing: list[Path] = []
    again = guides.remade(
        text, guides.prepared(tmp_path), lambda file, _: None if file.is_file() else missing.append(file)
    )
    assert missing == []
    assert NUMBER.sub("#", again) == NUMBER.sub("#", text)
    for shown, found in zip(NUMBER.findall(text), NUMBER.findall(again), strict=True):
        # Searches and draws differ a little between machines: 5 %, and p-values of any size.
        assert float(found.replace(",", "")) == pytest.approx(float(shown.replace(",", "")), rel=0.05, abs=2e-3)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target, anchor in re.findall(r"\]\((?!https?:)([^)#\s]*)(?:#([^)\s]*))?\)", text):
        other = (page.parent / target) if target else page
        assert other.exists(), target
        if anchor and other.suffix == ".md":
            assert anchor in anchors(other), f"{target}#{anchor}"


@cache
def anchors(page: Path) -> set[str]:
    """Anchors that GitHub makes of the headings of a page."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    headings = (re.sub(r"[`*$]|\[(.*?)\]\(.*?\)", r"\1", line) for line in re.findall(r"^#+ (.+)$", text, re.MULTILINE))
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


def test_pages_name_rooms_that_exist() -> None:
    for name in ("renamed", "glossary", "index"):
        for room in re.findall(r"`cp\.([a-z_]+(?:\.[a-z_]+)?)`", (DOCS / f"{name}.md").read_text(encoding="utf-8")):
            parts = room.split(".")
            folder = ROOT.joinpath("cycloid_profile", *parts)
            if not (folder / "__init__.py").is_file():
                face = ROOT.joinpath("cycloid_profile", *parts[:-1])
                stubs = [path.read_text(encoding="utf-8") for path in face.glob("__init__.py*")]
                assert any(re.search(rf"import {parts[-1]} as {parts[-1]}\b", text) for text in stubs), room


def test_yaml_of_the_repository_parses() -> None:
    files = [*(ROOT / ".github").rglob("*.yml"), ROOT / "mkdocs.yml", ROOT / "CITATION.cff"]
    assert len(files) == 7
    for path in files:
        assert isinstance(yaml.safe_load(path.read_text(encoding="utf-8")), dict), path.name


def workflow(name: str) -> dict[str, Any]:
    """Jobs of a workflow."""
    jobs = yaml.safe_load((ROOT / ".github" / "workflows" / name).read_text(encoding="utf-8"))["jobs"]
    assert isinstance(jobs, dict)
    return jobs


def test_workflow_runs_the_checks_on_linux() -> None:
    assert [step.get("run", "") for step in workflow("ci.yml")["linux"]["steps"]][-1] == ".ci/run"


def test_workflow_runs_the_readmes_command_on_three_systems_and_every_python() -> None:
    job = workflow("tests.yml")["tests"]
    commands = [step["run"] for step in job["steps"] if "pytest" in step.get("run", "")]
    (readme,) = re.findall(r"```bash\n(.*pytest)\n```", (ROOT / "README.md").read_text(encoding="utf-8"))
    assert commands[0] == readme
    assert commands[1] == readme.replace("python3", "python").replace(".venv/bin", ".venv/Scripts")
    matrix = job["strategy"]["matrix"]
    assert matrix["system"] == ["ubuntu", "windows", "macos"]
    assert f">={matrix['python'][0]}" == PROJECT["requires-python"]
    assert len(matrix["python"]) == len(set(matrix["python"])) >= 4


def test_conda_recipe_asks_for_the_same_libraries() -> None:
    text = (ROOT / "recipe" / "meta.yaml").read_text(encoding="utf-8")
    recipe = yaml.safe_load(jinja2.Template(text).render(load_file_data=lambda *_, **__: {"project": PROJECT}))
    assert recipe["package"]["version"] == PROJECT["version"]
    assert recipe["build"]["entry_points"] == [" = ".join(*PROJECT["scripts"].items())]
    other_names = {"matplotlib": "matplotlib-base", "lib3mf": "lib3mf-python"}
    wanted = [f"python{PROJECT['requires-python']}", *PROJECT["dependencies"]]
    named = [re.split(r"(?=>=)", one) for one in wanted]
    assert recipe["requirements"]["run"] == [f"{other_names.get(name, name)} {bound}" for name, bound in named]


def test_versions_agree() -> None:
    version = PROJECT["version"]
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))["version"] == version
    sections = re.split(r"^## ", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    assert sections[0].startswith(f"{version}\n")
    assert all(section.count("\n") <= 40 for section in sections)
