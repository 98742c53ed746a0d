"""Every effect that a plant may have: one class each, its parameters neutral unless given."""

from cogging._core.effects import *  # noqa: F403  (the list stands in the core alone)
