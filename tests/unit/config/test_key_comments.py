"""Comments of YAML by key."""

from __future__ import annotations

from pathlib import Path

from pipeline.key_comments import key_comments

TEXT = """\
# a header is no comment of a key
defaults:
  - _self_

rate: 2.0            # Hz; a comment
                     # that goes on
# a line at the margin belongs to nobody
name: "a # b"        # a text with a hash
bare: 1
list:                # on the next line
  [1, 2,
   3]                # and the last
box: {low: 1, high: {deep: 2}}   # m, of both
nested:              # of the whole
  inner: it's        # of one; an apostrophe opens no quote
  other: 3
items:               # of each
  - {size: 1}
  - size: 2          # m
long: >-             # chars
  # no comment
  text
"""


def test_each_key_has_the_comment_beside_it(tmp_path: Path) -> None:
    path = tmp_path / "x.yaml"
    path.write_text(TEXT, encoding="utf-8")
    found = key_comments(path)
    assert found["rate"] == "Hz; a comment that goes on"
    assert found["name"] == "a text with a hash"
    assert found["bare"] == ""
    assert found["list"] == "on the next line and the last"
    assert {found[key] for key in ("box", "box.low", "box.high", "box.high.deep")} == {"m, of both"}
    assert found["nested"] == "of the whole"
    assert found["nested.inner"] == "of one; an apostrophe opens no quote"
    assert found["nested.other"] == ""
    assert found["items.0.size"] == "of each"
    assert found["items.1.size"] == "m"
    assert found["long"] == "chars"


def test_a_file_without_keys_has_none(tmp_path: Path) -> None:
    path = tmp_path / "x.yaml"
    path.write_text("# nothing\n", encoding="utf-8")
    assert key_comments(path) == {}
