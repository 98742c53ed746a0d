"""Closed-loop runs of models, sweeps of many runs, and reference motions."""
