"""From a measured scan to a map of the cogging, and the periods of an error."""
