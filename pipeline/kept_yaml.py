"""Files below conf/ as Hydra reads them, parsed once in a process.

A run is composed of some fifty files, and most runs of a process share nearly all of them. Parsing
is half of what composing takes.
"""

from __future__ import annotations

import pickle
from functools import lru_cache
from pathlib import Path
from typing import cast

from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra._internal.core_plugins.file_config_source import FileConfigSource
from hydra.core.global_hydra import GlobalHydra
from hydra.plugins.config_source import ConfigResult

MAIN = "main"  # what Hydra calls the folder that it was initialised with


class KeptFiles(FileConfigSource):
    """A folder of YAML files that are parsed again only when they have changed."""

    def load_config(self, config_path: str) -> ConfigResult:
        """Return what a file holds, to be changed at will.

        Args:
            config_path: Relative to the folder, with or without its ending.

        Raises:
            ConfigLoadError: There is no such file.
        """
        path = Path(self.path) / self._normalize_file_name(config_path)
        if not path.exists():
            return super().load_config(config_path)  # says so
        entry = path.stat()
        state = (entry.st_mtime_ns, entry.st_size, entry.st_ino)
        return cast(
            ConfigResult, pickle.loads(_parsed(self.provider, self.path, config_path, state))
        )


@lru_cache(maxsize=1024)
def _parsed(provider: str, folder: str, config_path: str, state: tuple[int, ...]) -> bytes:
    """Parse a file; pickled, since Hydra changes what it gets and a copy takes five times as long.

    Args:
        provider: Hydra's name for the folder.
        folder: Where the file lies.
        config_path: The file, relative to the folder.
        state: Changes when the file does.
    """
    return pickle.dumps(FileConfigSource(provider, folder).load_config(config_path))


def keep_parsed_files() -> None:
    """Let the Hydra that is initialised keep what it reads."""
    loader = cast(ConfigLoaderImpl, GlobalHydra.instance().config_loader())
    repository = loader.repository
    repository.sources = [
        KeptFiles(source.provider, source.path) if source.provider == MAIN else source
        for source in repository.sources
    ]
