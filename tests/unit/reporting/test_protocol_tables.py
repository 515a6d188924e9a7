"""Tables and figure of protocols: from rows alone, whose ranking is known by hand."""

from __future__ import annotations

import pytest

from pipeline.data.tables import write_table
from pipeline.presentation.style import save, styled
from pipeline.reporting.bump_chart import Place, Stop, slots
from pipeline.reporting.results import read_results
from pipeline.reporting.topics.protocols import agreement, bumps, rankings, turned_pairs
from tests.protocol_rows import answers, facts, protocol

BY_SUCCESS = protocol(name="trac_ik", title="TRAC-IK", success__limits=True)
BY_TIME = protocol(name="frankik", title="frankik", rank__by="time", rank__digits=2)


def line(rules, solver, position_mm, time_us, machine="aaaa"):
    rows = answers(position_mm, time_us, machine=machine, robot="panda", solver=solver)
    return {("panda", rules.name, solver, 1): (rows, facts(rules))}


# By success lm and placo tie before bio_ik; by time (12, 12, 50 us, then 400) bio_ik ties with lm.
GIVEN = {
    **line(BY_SUCCESS, "lm", [0.1, 0.1], 12.0),
    **line(BY_SUCCESS, "placo", [0.9, 0.9], 50.0),
    **line(BY_SUCCESS, "bio_ik", [0.9, 1.1], 12.1),
    **line(BY_TIME, "lm", [0.1, 0.1], 12.0),
    **line(BY_TIME, "placo", [0.9, 0.9], 50.0),
    **line(BY_TIME, "bio_ik", [0.9, 1.1], 12.1),
}


def test_the_table_of_rankings_with_ties() -> None:
    found = [(r["protocol"], r["solver"], r["rank"]) for r in rankings(GIVEN).records()]
    assert found == [
        ("TRAC-IK", "LM, compiled", "1="),
        ("TRAC-IK", "placo", "1="),
        ("TRAC-IK", "BioIK", "3"),
        ("frankik", "BioIK", "1="),
        ("frankik", "LM, compiled", "1="),
        ("frankik", "placo", "3"),
    ]


def test_agreement_and_what_turned_the_pair() -> None:
    (pair,) = agreement(GIVEN).records()
    # Of three pairs lm-placo ties in the one, lm-bio_ik in the other, placo-bio_ik is reversed.
    assert (pair["tau"], pair["reversed"], pair["pairs"]) == (pytest.approx(-0.5), 1, 3)
    (turned,) = turned_pairs(GIVEN).records()
    assert (turned["first"], turned["second"]) == ("BioIK", "placo")
    assert (turned["ahead"], turned["behind"], turned["tied"]) == ("frankik", "TRAC-IK", None)
    assert turned["causes"] == "metric 1×"


def test_nothing_is_ranked_across_machines() -> None:
    given = {**line(BY_TIME, "lm", [0.1], 12.0), **line(BY_TIME, "placo", [0.1], 5.0, "bbbb")}
    assert [(r["machine"], r["rank"]) for r in rankings(given).records()] == [
        ("aaaa", "1"),
        ("bbbb", "1"),
    ]
    assert agreement(given).rows == []


def test_rows_by_other_rules_than_the_most_are_left_out() -> None:
    changed = protocol(name="frankik", title="frankik", rank__by="time", start="none")
    given = {**GIVEN, **line(changed, "placo", [0.9, 0.9], 1.0)}
    solvers = [r["solver"] for r in rankings(given).records() if r["protocol"] == "frankik"]
    assert solvers == ["BioIK", "LM, compiled"]


def test_those_that_tie_stand_together_in_the_order_of_their_neighbours() -> None:
    def stop(**places: int) -> Stop:
        return Stop("", "", [Place(name, rank, "") for name, rank in places.items()])

    stops = [stop(a=1, b=1, c=1), stop(a=3, b=2, c=1), stop(a=1, b=1, c=1, d=4)]
    assert [sorted(at, key=at.__getitem__) for at in slots(stops)] == [
        ["c", "b", "a"],
        ["c", "b", "a"],
        ["c", "b", "a", "d"],
    ]


def test_the_figure_is_made_of_files_of_rows_alone(tmp_path) -> None:
    for (robot, name, solver, size), (rows, known) in GIVEN.items():
        folder = tmp_path / "evaluate_protocol" / robot / name / solver
        write_table(folder / f"batch{size}.parquet", rows, known)
    read = read_results(tmp_path).protocols
    assert rankings(read).records() == rankings(GIVEN).records()
    with styled():
        figure = bumps(read)
        texts = [each.get_text() for each in figure.axes[0].texts]
        assert texts.count("LM, compiled") == texts.count("placo") == 2  # named at both ends
        assert {"TRAC-IK", "frankik", "100.0 %", "50.00 %", "0.012 ms", "0.050 ms"} <= set(texts)
        assert figure.axes[0].get_title("left").endswith("two protocols, two rankings: Panda")
        assert len(figure.axes[0].patches) == 2  # a frame around each tie
        first = save(figure, tmp_path / "one", "figure", 50)
        again = save(bumps(read), tmp_path / "two", "figure", 50)
    assert first[0].read_bytes() == again[0].read_bytes()
