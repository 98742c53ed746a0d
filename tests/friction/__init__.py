"""Tests of `friction`."""
