"""Maps in the forms that drives take: a table, or coefficients, with the law by which the drive reads it."""
