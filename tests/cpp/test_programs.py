"""What CTest says of the programs in C++: constructors, numbers, controllers as a drive has them, lanes, a soak."""

import xml.etree.ElementTree as ElementTree


def test_programs_pass(cmake, programs, tmp_path):
    report = tmp_path / "report.xml"
    cmake.run(cmake.ctest, "--test-dir", programs, "--output-on-failure", "-C", "Debug", "--output-junit", report)
    passed = {case.get("name") for case in ElementTree.parse(report).iter("testcase") if case.get("status") == "run"}
    assert passed == {"constructors", "drive", "drive_refuses", "lanes", "numbers", "soak"}
