"""What a model leaves unexplained of logs, and fits that make it small."""
