"""A prototype of one engine for `diagnose`; see README.md."""
