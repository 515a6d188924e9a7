import subprocess
import sys
from pathlib import Path

import pytest

from robots.compiled_cache import source_digest


def test_edit_of_compiled_code_gives_another_folder(tmp_path: Path) -> None:
    (tmp_path / "kernel.py").write_text("@njit\ndef f(): return 1")
    (tmp_path / "plain.py").write_text("x = 1")
    first = source_digest(tmp_path)
    (tmp_path / "plain.py").write_text("x = 2")
    assert source_digest(tmp_path) == first
    (tmp_path / "kernel.py").write_text("@njit\ndef f(): return 2")
    assert source_digest(tmp_path) != first


CALL = """
from robots import compiled_cache
compiled_cache.use_own_folder("robots")
import numba
{before}
@numba.njit(cache=True)
def doubled(x):
    return 2 * x
print(doubled(21), sum(doubled.stats.cache_hits.values()))
"""
FULL = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (10, resource.RLIM_INFINITY))"


def call(folder: Path, before: str = "") -> str:
    path = folder / "kernel.py"
    if not path.exists() or before:
        path.write_text(CALL.format(before=before))
    root = str(Path(__file__).parents[3])
    environment = {"NUMBA_CACHE_DIR": str(folder / "cache"), "PYTHONPATH": root}
    command = [sys.executable, str(path)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert not done.stderr
    return done.stdout.strip()


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize("share", [0.0, 0.3, 0.9])
def test_a_cache_that_is_cut_off_is_made_anew(suffix: str, share: float, tmp_path: Path) -> None:
    assert call(tmp_path) == "42 0"
    assert call(tmp_path) == "42 1"
    (path,) = (tmp_path / "cache").rglob(f"*.{suffix}")
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    assert call(tmp_path) == "42 0"
    assert call(tmp_path) == "42 1"


def test_a_disk_that_is_full_keeps_nothing_and_stops_no_call(tmp_path: Path) -> None:
    assert call(tmp_path, FULL) == "42 0"
    assert not [path for path in (tmp_path / "cache").rglob("*") if path.is_file()]
