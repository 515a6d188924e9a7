"""A constrained generative adversarial network: an ensemble of generators and a discriminator.

Declares the method and imports nothing that needs torch: the configuration reads it.
"""

from pipeline.learning.method import Method

METHOD = Method(
    networks={"gan": "pipeline.learning.gan.network.Gan"},
    objective="pipeline.learning.gan.objective.GanObjective",
    model="gan",
    config="pipeline.learning.gan.config.GanModel",
    trained_for="adversarial",
)
