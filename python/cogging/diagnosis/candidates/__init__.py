"""The effects that are tried, each at its best shape."""
