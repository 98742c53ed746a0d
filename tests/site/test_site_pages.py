"""What the site takes from elsewhere in the repository: links that fit both, notebooks with and without outputs."""

import runpy

import api_pages
from site_pages import DOCS

import cogging


def test_every_published_version_lists_all_and_the_front_page_leads_to_the_newest_release(tmp_path):
    publish = runpy.run_path(str(DOCS / "publish.py"))["publish"]
    built, published = tmp_path / "built", tmp_path / "published"
    (built / "_static").mkdir(parents=True)
    (built / "_static" / "versions.js").write_text((DOCS / "_static" / "versions.js").read_text())
    for name in ("latest", "v0.9.0", "v0.10.0", "latest"):
        (built / "index.html").write_text(name)
        publish(built, published, name)
        assert (published / name / "index.html").read_text() == name
    for name in ("latest", "v0.9.0", "v0.10.0"):
        listed = (published / name / "_static" / "versions.js").read_text()
        assert listed == 'const VERSIONS = ["v0.10.0", "v0.9.0", "latest"];\n'
    assert "url=v0.10.0/index.html" in (published / "index.html").read_text()


def test_every_public_name_has_one_room():
    assert sorted([name for named in api_pages.rooms().values() for name in named]) == sorted(cogging.__all__)
