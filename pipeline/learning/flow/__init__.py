"""A conditional normalizing flow, in the manner of IKFlow: many solutions of a pose.

Declares the method and imports nothing that needs torch: the configuration reads it.
"""

from pipeline.learning.method import Method

METHOD = Method(
    networks={"flow": "pipeline.learning.flow.network.FlowNetwork"},
    objective="pipeline.learning.flow.objective.FlowObjective",
    model="flow",
    config="pipeline.learning.flow.config.FlowModel",
    trained_for="likelihood",
)
