"""The table of the panel: what each solver says to the target, as HTML."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from pipeline.presentation.naming import solver_title
from pipeline.presentation.style import looks
from pipeline.viewing.comparison import Answer

HEAD = ("", "solver", "mm", "deg", "µs", "jump")
STYLE = "font-size:0.78em;width:100%;border-collapse:collapse;font-variant-numeric:tabular-nums"
LEGEND = (
    "Distance and angle from the target; time of a call, the median of the last ones; largest "
    "change of a joint [rad or m]. Solid robot: bold. ⚠ touches itself, ✗ not found, as it says."
)


def answers_html(answers: Mapping[str, Answer], main: str) -> str:
    """Return a table with a row a solver, each with its colour of the figures.

    Args:
        answers: By the solver's name.
        main: Name of the solver that the solid robot follows.
    """
    colours = looks(answers)
    cells = "".join(
        f'<th style="text-align:{"left" if k < 2 else "right"};padding:2px 4px">{name}</th>'
        for k, name in enumerate(HEAD)
    )
    rows = "".join(_row(answers[name], colours[name].colour, name == main) for name in colours)
    return (
        f'<div style="padding:0 0.6em"><table style="{STYLE}"><tr>{cells}</tr>{rows}</table>'
        f'<div style="font-size:0.68em;opacity:0.7;margin-top:4px">{LEGEND}</div></div>'
    )


def sentence_html(sentence: str) -> str:
    """Return a sentence for the user; an empty one keeps its place."""
    text = escape(sentence) or "&nbsp;"
    return f'<div style="font-size:0.8em;padding:0 0.6em;min-height:2.6em">{text}</div>'


def _row(answer: Answer, colour: str, main: bool) -> str:
    marks = ("⚠" if answer.colliding else "") + ("" if answer.found else "✗")
    swatch = (
        f'<span style="display:inline-block;width:0.9em;height:0.9em;border-radius:2px;'
        f'background:{colour}"></span>'
    )
    numbers = (
        f"{answer.position_mm:.3f}",
        f"{answer.rotation_deg:.3f}",
        f"{answer.call_us:.0f}",
        f"{answer.jump:.3f}",
    )
    weight = "bold" if main else "normal"
    name = f"{escape(solver_title(answer.solver))} {marks}"
    cells = "".join(f'<td style="text-align:right;padding:2px 4px">{each}</td>' for each in numbers)
    return (
        f'<tr style="font-weight:{weight}"><td style="padding:2px 4px">{swatch}</td>'
        f"<td>{name}</td>{cells}</tr>"
    )
