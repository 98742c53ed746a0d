"""What CTest says of the programs in C++: constructors, numbers, controllers as a drive has them, a soak.

`lanes` takes long and is left to test_lanes.py, which runs it too and says more of what it prints.
"""

import xml.etree.ElementTree as ElementTree


def test_programs_pass(cmake, programs, tmp_path):
    report = tmp_path / "report.xml"
    options = ["--exclude-regex", "^lanes$", "--output-on-failure", "-C", "Debug", "--output-junit", report]
    cmake.run(cmake.ctest, "--test-dir", programs, *options)
    passed = {case.get("name") for case in ElementTree.parse(report).iter("testcase") if case.get("status") == "run"}
    assert passed == {"constructors", "drive", "drive_refuses", "numbers", "soak"}
