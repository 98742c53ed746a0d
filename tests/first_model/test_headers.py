"""What a header says: what a column holds and in which unit, in the ways in which drives and loggers write it."""

import pytest

from cogging.first_model.headers import WORDS, header_of

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


def test_no_word_means_two_things():
    words = [word for known in WORDS.values() for word in known]
    assert len(words) == len(set(words)) > 100


@pytest.mark.parametrize(
    ("label", "unit"),
    [
        ("x" + " " * 200_000, ""),
        ("x" + " " * 200_000 + "[mm]", "mm"),
        ("x [" + " " * 200_000 + "mm", ""),
        ("x [" + " " * 200_000 + "mm]", "mm"),
        ("[" * 200_000, ""),
        ("x" + " ," * 100_000, ""),
        ("(" + " )" * 100_000, ""),
        ("x" + " in" * 70_000 + "(", ""),
    ],
    ids=range(8),
)
def test_a_name_without_end_takes_no_time_without_end(label, unit):
    """A pattern looked at such names once for each pair, or three, of their blanks: minutes to years."""
    assert header_of(label).unit == unit
