"""How results are shown: names, tables, the style of figures, the paper's numbers beside ours."""
