"""The engine: one force balance along the measured motion, what it is short of, and what that is decided to be."""
