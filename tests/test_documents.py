"""Documents lead somewhere, the tools' versions agree, and the front page is no lab book."""

import re
import sys
from pathlib import Path

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[1]
DOCUMENTS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "papers").glob("*.md")])


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_links_lead_to_files_that_are_there(path):
    text = re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    links = re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", text)
    for link in links:
        if not link.startswith(("http:", "https:")):
            assert (path.parent / link).exists(), link


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_test_files_that_are_named_are_there(path):
    if path.name == "CHANGELOG.md":  # tells of what was
        return
    for name in re.findall(r"\btests/[\w/]+\.py\b", path.read_text(encoding="utf-8")):
        assert (ROOT / name).exists(), name


def test_the_hooks_have_the_versions_of_the_lint_extra():
    lint = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]["lint"]
    stated = dict(requirement.split("==") for requirement in lint)
    hooks = (ROOT / ".pre-commit-config.yaml").read_text()
    for tool, repository in (("ruff", "ruff-pre-commit"), ("clang-format", "mirrors-clang-format")):
        (version,) = re.findall(rf"/{repository}\n\s+rev: v([\d.]+)", hooks)
        assert version == stated[tool]


def test_the_front_page_is_short():
    lines = (ROOT / "README.md").read_text().splitlines()
    assert len(lines) < 100


def test_the_citation_names_the_three_papers():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    for number in ("DSCC2008-2182", "10.1109/CDC.2009.5399831", "Automatica"):
        assert number in text
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert f"\nversion: {version}\n" in text
