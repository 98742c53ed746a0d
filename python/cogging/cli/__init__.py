"""The command `cogging`."""
