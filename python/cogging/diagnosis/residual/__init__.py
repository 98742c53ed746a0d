"""What is left unexplained, and where it sits, before anything is named."""
