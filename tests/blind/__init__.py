"""Blind test bed of `cogging diagnose`: machines with a hidden effect, by code that shares nothing with the core."""
