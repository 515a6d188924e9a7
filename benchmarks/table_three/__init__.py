"""Table III of the paper with rows of our own."""
