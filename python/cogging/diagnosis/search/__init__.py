"""Scan, choose, refit, accept: which effects are added to the model."""
