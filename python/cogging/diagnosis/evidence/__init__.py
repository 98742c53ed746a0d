"""What logs say against a model: whitened residuals, freed of all that re-tuning could explain."""
