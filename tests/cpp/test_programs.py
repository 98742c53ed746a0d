"""The programs in C++ by CTest: numbers, and a soak of the controllers as a drive has them."""

import xml.etree.ElementTree as ElementTree


def test_programs_pass(cmake, programs, tmp_path):
    report = tmp_path / "report.xml"
    options = ["--output-on-failure", "-C", "Debug", "--output-junit", report]
    cmake.run(cmake.ctest, "--test-dir", programs, *options)
    passed = {case.get("name") for case in ElementTree.parse(report).iter("testcase") if case.get("status") == "run"}
    assert passed == {"numbers", "soak", "soak_refuses"}
