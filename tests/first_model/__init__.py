"""Tests of `first_model`."""
