"""Versions: each dependency has a lowest one, and continuous integration tries what is allowed."""

import importlib.util
import re
import sys
from pathlib import Path

import pytest
import yaml

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
EXTRAS = PROJECT["project"]["optional-dependencies"]
TOOLS = PROJECT["tool"]
spec = importlib.util.spec_from_file_location("allowed_versions", ROOT / "packaging" / "allowed_versions.py")
ALLOWED = importlib.util.module_from_spec(spec)
spec.loader.exec_module(ALLOWED)


def name_of(requirement):
    return re.match(r"[\w.-]+", requirement)[0]


def bounds_of(requirement):
    """The rules of a requirement: ['>=1.24']."""
    return re.sub(r"^[\w.-]+(\[[\w,-]+\])?", "", requirement.partition(";")[0]).strip().split(",")


def everything():
    return [*ALLOWED.requirements(list(EXTRAS), []), *ALLOWED.build_requirements()]


@pytest.mark.parametrize("requirement", sorted(set(everything())))
def test_each_dependency_has_a_lowest_version(requirement):
    rules = bounds_of(requirement)
    assert sum(bool(re.fullmatch(r"(>=|==)\d[\d.]*", rule)) for rule in rules) == 1, rules


@pytest.mark.parametrize(("rule", "bounds"), [("a", [""]), ("a<2", ["<2"]), ("a[b]>=1.2,<3; c", [">=1.2", "<3"])])
def test_a_requirement_is_read(rule, bounds):
    assert (name_of(rule), bounds_of(rule)) == ("a", bounds)


def test_one_package_has_one_bound_everywhere():
    """Of extras and of the build alike, but for two tools that the tests want newer than a build does."""
    seen = {}
    for requirement in everything():
        seen.setdefault(name_of(requirement), set()).add(requirement)
    assert {name: rules for name, rules in seen.items() if len(rules) > 1} == {
        "cmake": {"cmake>=3.20", "cmake>=3.21"},
        "ninja": {"ninja>=1.5", "ninja>=1.10"},
    }


def test_extras_of_extras_are_opened():
    asked = ALLOWED.requirements(["test"], [])
    assert not [one for one in asked if one.startswith("cogging")]
    for extra in ("control", "dask", "frames", "matlab", "mdf", "parquet", "report", "tune"):
        assert set(EXTRAS[extra]) <= set(asked), extra
    assert set(PROJECT["project"]["dependencies"]) <= set(asked)
    without = ALLOWED.requirements(["test"], ["mdf"])
    assert set(asked) - set(without) == set(EXTRAS["mdf"])


def workflow(name):
    folder = ROOT / ".github" / "workflows"
    return yaml.safe_load((folder / f"{name}.yml").read_text(encoding="utf-8"))


def steps_of(job):
    return [step["run"] for step in job["steps"] if "run" in step]


def test_the_weekly_job_tries_both_ends():
    told = workflow("weekly")
    assert re.fullmatch(r"\d+ \d+ \* \* \d", told[True]["schedule"][0]["cron"])  # YAML reads the key `on` as true
    job = told["jobs"]["allowed"]
    tried = {(one["versions"], one["python"], one["more"]) for one in job["strategy"]["matrix"]["include"]}
    oldest, latest = versions_of_python()[0], versions_of_python()[-1]
    assert {("lowest", oldest, ""), ("newest", latest, ""), ("lowest", oldest, "--without mdf")} <= tried
    assert {which for which, *_ in tried} == set(ALLOWED.CHOICES)
    make, test = steps_of(job)[-2:]
    place = re.fullmatch(r"python packaging/allowed_versions\.py \S+ \S+ \S+ (\S+) .*", make)[1]
    assert test.startswith(f"{place}/bin/python -m pytest ")
    assert test.partition("pytest ")[2] == steps_of(workflow("ci")["jobs"]["quick"])[-1].partition("pytest ")[2]


def versions_of_python():
    """Those that the wheels are built for: ['3.10', ...]."""
    return [f"3.{name[3:-2]}" for name in TOOLS["cibuildwheel"]["build"]]


def test_one_list_of_pythons():
    versions = versions_of_python()
    assert PROJECT["project"]["requires-python"] == f">={versions[0]}"
    classifiers = PROJECT["project"]["classifiers"]
    assert [one for one in classifiers if "3." in one] == [f"Programming Language :: Python :: {v}" for v in versions]
    matrix = workflow("ci")["jobs"]["quick"]["strategy"]["matrix"]
    assert matrix["python"] == versions
    assert {name.partition("-")[0] for name in matrix["os"]} == {"ubuntu", "macos", "windows"}
