"""A first model and a first reference from a log as its owner has it."""
