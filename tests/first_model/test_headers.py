"""What a column holds and in which unit, from headers as drives and loggers write them."""

import pytest

from cogging.first_model.headers import header_of

#: Kind and unit of each label.
LABELS = {
    "Zeit in s": ("time", "s"),
    "t_ms": ("time", "ms"),
    "Time [us]": ("time", "us"),
    "Istposition / mm": ("position", "mm"),
    "pos_um": ("position", "um"),
    "Axis 1 Position Actual Value": ("position", ""),
    "theta [deg]": ("position", "deg"),
    "Actual position [counts]": ("position", "counts"),
    "x_A": ("position", ""),  # an axis called A, not amperes
    "x [mm/s]": ("velocity", "mm/s"),
    "Drehzahl [1/min]": ("velocity", "1/min"),
    "Motorstrom / A": ("command", "A"),
    "Stellgröße [V]": ("command", "V"),
    "torque [%]": ("command", "%"),
    "force (filtered)": ("command", ""),
    "Sollposition [mm]": ("reference", "mm"),
    "Reference Velocity": ("reference_velocity", ""),
    "Error Position": ("error", ""),
    "Temperatur": ("", ""),
    "kp": ("", ""),
    "": ("", ""),
    # A pattern that looks at each pair of their blanks needs minutes to years.
    "x" + " " * 200_000 + "[mm]": ("position", "mm"),
    "x" + " in" * 70_000 + "(": ("position", ""),
    "[" * 200_000: ("", ""),
}


@pytest.mark.parametrize("label", LABELS, ids=lambda label: label[:30])
def test_kind_and_unit_of_a_label(label):
    header = header_of(label)
    assert (header.kind, header.unit, header.label) == (*LABELS[label], label)


@pytest.mark.parametrize("unit", ["mm", "V", "ms"])
def test_a_unit_apart_from_the_name_counts_where_the_name_has_none(unit):
    assert header_of("ch1", unit).unit == unit
    assert header_of("ch1 [A]", unit).unit == "A"
