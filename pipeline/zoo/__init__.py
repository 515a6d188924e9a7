"""Many arms of others, and where a neural seed is worth its training."""
