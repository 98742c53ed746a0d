"""What was added, by name, with alternatives and confidence; the verdict."""
