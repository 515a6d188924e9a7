"""Whether a table of raw rows is there already and answers the same question."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline.data.tables import TableError, read_metadata


def is_up_to_date(path: Path, key: Mapping[str, Any]) -> bool:
    """Say whether a table holds the rows of a question.

    Args:
        path: Raw rows, or nothing yet.
        key: What the rows would depend on, from `cache_key` in `pipeline.evaluation.runner`.

    Returns:
        False where the file is missing, damaged or answers another question.
    """
    try:
        facts = read_metadata(path)
    except TableError:
        return False
    wanted = json.loads(json.dumps(dict(key), default=str))
    return all(key in facts and facts[key] == value for key, value in wanted.items())
