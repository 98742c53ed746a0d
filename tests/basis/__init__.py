"""Tests of `basis`."""
