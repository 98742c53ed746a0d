"""Where simulation and measurement disagree, and the effect that would explain it."""

from cogging.diagnose.diagnosis import diagnose
from cogging.diagnose.location import Location, Wave, locate_gap
from cogging.diagnose.result import Diagnosis, Gap, NamedEffect, Placebo, Step, Value

__all__ = ["Diagnosis", "Gap", "Location", "NamedEffect", "Placebo", "Step", "Value", "Wave", "diagnose", "locate_gap"]
