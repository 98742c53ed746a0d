"""Where simulation and measurement disagree, and the effect that would explain it."""

from cogging.diagnose.diagnosis import diagnose
from cogging.diagnose.result import Diagnosis, Gap, NamedEffect, Step, Value

__all__ = ["Diagnosis", "Gap", "NamedEffect", "Step", "Value", "diagnose"]
