"""The engine of `diagnose`: the force balance along the measured motion."""
