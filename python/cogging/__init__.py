"""Cogging of permanent-magnet linear motors: simulate, control and identify the axis."""

from cogging._core import *  # noqa: F403
