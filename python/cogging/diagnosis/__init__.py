"""Where simulation and measurement disagree, and the effect that would explain it."""
