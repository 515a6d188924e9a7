"""NODE IK: a conditional flow that is continuous in time, the solution of a neural equation.

Declares the method and imports nothing that needs torch: the configuration reads it.
"""

from pipeline.learning.method import Method

METHOD = Method(
    networks={"node_ik": "pipeline.learning.node_ik.network.NodeIk"},
    objective="pipeline.learning.node_ik.objective.NodeIkObjective",
    model="node_ik",
    config="pipeline.learning.node_ik.config.NodeIkModel",
    trained_for="likelihood",
)
