"""Whether a model explains a log at all, and whether the log would fit it if a column were read otherwise."""
