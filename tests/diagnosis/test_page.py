"""The report."""

import pytest
from markupsafe import escape


def test_a_report_without_its_library_says_what_to_install(found, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "jinja2", None)
    with pytest.raises(ValueError, match=r"a report needs jinja2: pip install 'cogging\[report\]'"):
        found.html()


def test_the_report_says_what_why_and_what_next(found):
    page = found.html(title="log <1>")
    assert "log &lt;1&gt;" in page
    for words in (
        "viscous asymmetry",
        "standard deviations out of the noise",
        "Check on other motion",
        "Before and after",
        "Everything that was tried in earnest",
        "effects.viscous_asymmetry.difference",
        "How to read this page",
    ):
        assert words in page, words
    assert found.location.lines()
    assert all(str(escape(line)) in page for line in found.location.lines())
    assert len(found.plot().axes) == 6
