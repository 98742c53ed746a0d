"""Gains for an uncertain machine: drawn machines, limits, margins, trials."""
