"""One reader a file format: each gives the columns that a Request asks for, as arrays of real numbers."""
