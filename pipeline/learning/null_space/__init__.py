"""Null-space generators: pose and noise in, another solution for another noise.

Declares the method and imports nothing that needs torch: the configuration reads it.
"""

from pipeline.learning.method import Method

METHOD = Method(
    networks={
        "null_space": "pipeline.learning.null_space.network.NullSpaceResidual",
        "null_space_mlp": "pipeline.learning.null_space.network.NullSpaceMlp",
    },
    objective="pipeline.learning.null_space.objective.NullSpaceObjective",
    model="null_space",
)
