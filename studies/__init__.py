"""What was run once to choose something that is shipped, or will be."""
