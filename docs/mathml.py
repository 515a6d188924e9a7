"""Hook of mkdocs: formulas in LaTeX become MathML, which browsers draw without a script.

A block fenced as `math` is a formula of its own, and $`...`$ one within a line: GitHub shows both.
"""

from __future__ import annotations

import re
from typing import Any

from latex2mathml.converter import convert

BLOCK = re.compile(r"^```math\n(.*?)^```$", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"\$`([^`]+)`\$")


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Replace the formulas of a page."""
    with_blocks = BLOCK.sub(
        lambda m: f'<div class="formula">{_mathml(m[1], "block")}</div>', markdown
    )
    # In a span, since Markdown takes `math` at the start of a line for a block.
    return INLINE.sub(lambda m: f"<span>{_mathml(m[1], 'inline')}</span>", with_blocks)


def _mathml(latex: str, display: str) -> str:
    return str(convert(" ".join(latex.split()), display=display))
