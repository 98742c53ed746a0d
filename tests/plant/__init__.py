"""Tests of `plant`."""
