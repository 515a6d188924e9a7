from pathlib import Path

from robots.compiled_cache import source_digest


def test_edit_of_compiled_code_gives_another_folder(tmp_path: Path) -> None:
    (tmp_path / "kernel.py").write_text("@njit\ndef f(): return 1")
    (tmp_path / "plain.py").write_text("x = 1")
    first = source_digest(tmp_path)
    (tmp_path / "plain.py").write_text("x = 2")
    assert source_digest(tmp_path) == first
    (tmp_path / "kernel.py").write_text("@njit\ndef f(): return 2")
    assert source_digest(tmp_path) != first
