"""IKNet: a hypernetwork of the pose makes small networks that draw one joint after the other.

Declares the method and imports nothing that needs torch: the configuration reads it.
"""

from pipeline.learning.method import Method

METHOD = Method(
    networks={"iknet": "pipeline.learning.iknet.network.IkNet"},
    objective="pipeline.learning.iknet.objective.IkNetObjective",
    model="iknet",
    config="pipeline.learning.iknet.config.IkNetModel",
    trained_for="likelihood",
)
