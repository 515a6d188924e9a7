"""The stages: each calls the library and writes one artifact with its card.

`graph` declares them, `running` runs one and what it lacks.
"""
