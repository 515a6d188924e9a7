"""A robot in several postures in one picture: what all share is solid, what one has is faint."""

from __future__ import annotations

import numpy as np

from robots import load_robot
from robots.picture import BACKGROUND, draw_overlay


def test_postures_over_each_other_cover_what_each_alone_covers() -> None:
    panda = load_robot("panda")
    postures = np.stack([panda.home, panda.home + np.eye(7)[0]])
    both = np.asarray(draw_overlay(panda, postures), dtype=int)
    alone = [np.asarray(draw_overlay(panda, posture[None]), dtype=int) for posture in postures]
    seen = [np.abs(picture - np.array(BACKGROUND)).sum(axis=2) > 15 for picture in alone]
    covered = np.abs(both - np.array(BACKGROUND)).sum(axis=2) > 3
    assert seen[0].any() and (seen[0] ^ seen[1]).any()
    assert covered[seen[0] | seen[1]].mean() > 0.98
    again = np.asarray(draw_overlay(panda, postures), dtype=int)
    np.testing.assert_array_equal(both, again)
