"""How others measure, as data: targets, starts and budgets, and how rows become a ranking."""
