"""The model of an axis, its parameters by path, and between which numbers they lie."""
