"""Tests of `log_check`."""
