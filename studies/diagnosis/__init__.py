"""Studies of `diagnose`: each round of a search, and measured logs."""
