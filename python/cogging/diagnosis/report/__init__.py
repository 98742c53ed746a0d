"""A diagnosis as a page and as figures."""
