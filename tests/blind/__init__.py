"""Blind test bed of `cogging diagnose`: machines with a hidden effect, written by code that shares nothing with the core."""
