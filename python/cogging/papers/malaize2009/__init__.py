"""Malaize and Levine 2009: observer-based cancellation, LMI gains, Table I."""
