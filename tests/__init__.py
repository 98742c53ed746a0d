"""Tests of the package, one file for each room; `blind` is the blind test bed of `diagnose`."""
