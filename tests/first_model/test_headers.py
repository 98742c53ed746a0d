"""What a header says: what a column holds and in which unit, in the ways in which drives and loggers write it."""

import pytest

from cogging.first_model.headers import header_of

SAID = {
    "Zeit in s": ("time", "s"),
    "t_ms": ("time", "ms"),
    "Time [us]": ("time", "us"),
    "Timestamp": ("time", ""),
    "Istposition / mm": ("position", "mm"),
    "Position, mm": ("position", "mm"),
    "pos_um": ("position", "um"),
    "Axis1.ActPos [mm]": ("position", "mm"),
    "Axis 1 Position Actual Value": ("position", ""),
    "theta [deg]": ("position", "deg"),
    "Actual position [counts]": ("position", "counts"),
    "x_A": ("position", ""),  # an axis called A, not amperes
    "x [mm/s]": ("velocity", "mm/s"),
    "Drehzahl [1/min]": ("velocity", "1/min"),
    "Motorstrom / A": ("command", "A"),
    "phase current A": ("command", "A"),
    "DriveCurrent_mA": ("command", "mA"),
    "Stellgröße [V]": ("command", "V"),
    "torque [%]": ("command", "%"),
    "force (filtered)": ("command", ""),
    "Sollposition [mm]": ("reference", "mm"),
    "PositionDemand": ("reference", ""),
    "x_soll [mm]": ("reference", "mm"),
    "Reference Velocity": ("reference_velocity", ""),
    "Error Position": ("error", ""),
    "Vsupply": ("", ""),
    "Temperatur": ("", ""),
    "kp": ("", ""),
    "": ("", ""),
}


@pytest.mark.parametrize("label", SAID)
def test_what_a_header_says(label):
    header = header_of(label)
    assert (header.kind, header.unit) == SAID[label]
    assert header.label == label


@pytest.mark.parametrize("unit", ["mm", "V", "ms"])
def test_a_unit_apart_from_the_name_counts(unit):
    assert header_of("ch1", unit).unit == unit
    assert header_of("ch1 [A]", unit).unit == "A"


@pytest.mark.parametrize(
    ("label", "unit"),
    [
        ("x" + " " * 200_000 + "[mm]", "mm"),
        ("x [" + " " * 200_000 + "mm]", "mm"),
        ("[" * 200_000, ""),
        ("x" + " ," * 100_000, ""),
        ("x" + " in" * 70_000 + "(", ""),
    ],
    ids=range(5),
)
def test_a_name_without_end_is_read_at_once(label, unit):
    """A pattern that looks at each pair of their blanks needs minutes to years."""
    assert header_of(label).unit == unit
