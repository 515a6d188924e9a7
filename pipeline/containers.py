"""Configuration dataclasses as plain containers, for cards and for the keys of kept rows."""

from __future__ import annotations

from typing import Any, cast

from omegaconf import OmegaConf


def to_dict(config: Any) -> dict[str, Any]:
    """Return a configuration dataclass as plain containers, ready for JSON."""
    container = OmegaConf.to_container(OmegaConf.structured(config), resolve=True)
    return cast(dict[str, Any], container)
