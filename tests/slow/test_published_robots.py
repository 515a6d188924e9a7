"""URDFs of installed packages: added, loaded, sampled and solved, whatever their shape.

    pytest -m slow tests/slow/test_published_robots.py

The study benchmarks/published_robots.py makes the table; what it claims is held here.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.published_robots import chain_of, name_of, study, urdf_files
from robots.urdf_reader import read_urdf

pytestmark = pytest.mark.slow
FILES = sorted(urdf_files())
POSES = 200
LEAST_ROBOTS = 40
# Two forward kinematics of one chain in double precision.
AGREEMENT_M = 1e-9
LM_FINDS = 0.99  # of reachable poses, on a busy machine
NEVER_SKIP = {"lm", "bio_ik"}  # coupled joints neither


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_a_published_robot_is_solved_within_its_limits_and_no_claim_is_wrong(path: Path) -> None:
    chain = chain_of(path)
    if chain is None:
        pytest.skip("no robot, or refused in a sentence")
    rows = study(path, *chain, POSES)
    solved = {row["solver"]: row for row in rows}
    assert solved.keys() >= NEVER_SKIP
    assert solved["lm"]["found"] >= LM_FINDS
    for name, row in solved.items():
        assert row["fk_error_m"] < AGREEMENT_M
        assert row["wrong"] == 0, name
        assert row["outside"] == 0, name
        assert row["found"] > 0, name


def test_packages_hold_forty_robots_of_many_shapes() -> None:
    chains = {path: chain for path in FILES if (chain := chain_of(path)) is not None}
    assert len(chains) >= LEAST_ROBOTS
    lengths = {len(read_urdf(path).path_between(*chain)) for path, chain in chains.items()}
    assert len(lengths) >= 6
