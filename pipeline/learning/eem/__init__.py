"""Equivariant model on the robot's distance graph: a conditional variational autoencoder.

Declares the method and imports nothing that needs torch: the configuration reads it.
"""

from pipeline.learning.method import Method

METHOD = Method(
    networks={"eem": "pipeline.learning.eem.network.Eem"},
    objective="pipeline.learning.eem.objective.EemObjective",
    model="eem",
    config="pipeline.learning.eem.config.EemModel",
    trained_for="evidence bound",
)
