"""The next experiment: a motion within the limits of a machine, and what is to be expected of it."""
