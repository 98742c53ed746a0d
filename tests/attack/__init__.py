"""Attacks: seeded calls, files and moments that no careful user would give. `python -m tests.attack --help`."""
