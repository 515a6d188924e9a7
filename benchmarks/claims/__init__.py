"""Small experiments that decide claims of the paper, with rules written before their run."""
