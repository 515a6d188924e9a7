"""CycleIK: a network trained through forward kinematics, so that pose -> joints -> pose closes.

Declares the method and imports nothing that needs torch: the configuration reads it.
"""

from pipeline.learning.method import Method

METHOD = Method(
    networks={
        "mlp": "pipeline.learning.cycleik.mlp.CycleIkMlp",
        "experts": "pipeline.learning.cycleik.experts.Experts",
    },
    objective="pipeline.learning.cycleik.objective.CycleObjective",
    model="compact",
    config="pipeline.learning.cycleik.config.CycleIkModel",
)
