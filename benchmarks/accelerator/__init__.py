"""Table I, first draws, losses and a search on one accelerator; see `__main__`."""
