"""What a search found, as a training takes it (`train.from=best`)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.data.files import read_sealed_yaml
from pipeline.errors import PipelineError

if TYPE_CHECKING:
    from pipeline.settings import Config


def read_best(path: Path, config: Config) -> tuple[dict[str, Any], dict[str, Any]]:
    """Read the values of train and model that a search found for a run's model.

    Raises:
        PipelineError: It searched another kind of model.
    """
    found = read_sealed_yaml(path)
    of = found.get("of") or {}
    if of.get("kind", config.model.kind) != config.model.kind:
        raise PipelineError(
            f"{path} is the best {of['model']} (kind {of['kind']}), and this run trains "
            f"{config.model.name} (kind {config.model.kind}): set model={of['model']}, or search "
            f"for this one with: python -m pipeline tune robot={config.robot.name} "
            f"profile={config.profile} model={config.model.name}"
        )
    return dict(found.get("train") or {}), dict(found.get("model") or {})
