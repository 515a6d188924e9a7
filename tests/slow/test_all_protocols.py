"""All six protocols, a solver that is not installed among those that are, and one figure."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from pipeline.__main__ import main
from pipeline.reporting.topics.protocols import ORDER

pytestmark = pytest.mark.slow


def test_two_solvers_by_all_six_protocols(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("baselines.mink_ik.Mink.requires", ("no_such_module",))
    run = ["robot=nico", "profile=smoke", "protocol.solvers=[lm,pinocchio,mink]"]
    assert main(["protocols", *run, f"results_dir={tmp_path}"]) == 0
    assert "mink (not installed: no_such_module)" in capfd.readouterr().out
    folders = sorted(path.name for path in (tmp_path / "evaluate_protocol" / "nico").iterdir())
    assert folders == sorted(ORDER)
    out = tmp_path / "protocols" / "nico"
    assert len(pd.read_csv(out / "protocol_agreement.csv")) == 15
    ranked = pd.read_csv(out / "protocols.csv")
    assert set(ranked.solver) == {"LM, compiled", "Pinocchio LM"}
    assert ranked.protocol.nunique() == 6
    assert (out / "protocols.png").stat().st_size > 10_000
