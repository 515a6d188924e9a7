from pathlib import Path

import pytest

from robots import load_robot
from robots.description import FILE, read_description
from robots.errors import DescriptionError
from robots.picture import draw_postures

GIVEN = "target: [0, 0, 0.5], distance: 2.0, yaw: 50, pitch: -10, seed: 1"


def described(folder: Path, picture: str) -> Path:
    path = folder / FILE
    path.write_text(f"name: a\ntitle: A\nurdf: a.urdf\nbase: a\ntip: b\npicture: {{{picture}}}\n")
    return path


def test_camera_is_read(tmp_path: Path) -> None:
    picture = read_description(described(tmp_path, GIVEN)).picture
    assert picture is not None
    assert picture.target.tolist() == [0.0, 0.0, 0.5]
    assert (picture.distance, picture.yaw, picture.pitch, picture.seed) == (2.0, 50.0, -10.0, 1)


@pytest.mark.parametrize(
    ("wrong", "expected"),
    [
        (GIVEN + ", zoom: 2", "expected the keys"),
        (GIVEN.replace(", seed: 1", ""), "expected the keys"),
        (GIVEN.replace("2.0", "0"), "positive distance"),
        (GIVEN.replace("2.0", "far"), "picture.distance reads far"),
        (GIVEN.replace("seed: 1", "seed: 1.5"), "whole number"),
        (GIVEN.replace("[0, 0, 0.5]", "[0, 0]"), r"\(3,\)"),
    ],
)
def test_wrong_camera_is_named(tmp_path: Path, wrong: str, expected: str) -> None:
    with pytest.raises(DescriptionError, match=expected):
        read_description(described(tmp_path, wrong))


def test_robot_without_camera_has_no_picture(two_link_urdf: Path) -> None:
    with pytest.raises(DescriptionError, match="no `picture`"):
        draw_postures(load_robot(urdf=two_link_urdf))
