"""Programs without Python, built from the headers alone."""
