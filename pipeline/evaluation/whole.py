"""Whether a table of raw rows is there already and answers the same question."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline.data.tables import TableError, read_metadata


def is_whole(path: Path, asked: Mapping[str, Any]) -> bool:
    """Say whether a table holds the rows of a question.

    Args:
        path: Raw rows, or nothing yet.
        asked: What the rows would depend on, from `question` in `pipeline.evaluation.runner`.

    Returns:
        False where the file is missing, damaged or answers another question.
    """
    try:
        facts = read_metadata(path)
    except TableError:
        return False
    wanted = json.loads(json.dumps(dict(asked), default=str))
    return all(key in facts and facts[key] == value for key, value in wanted.items())
