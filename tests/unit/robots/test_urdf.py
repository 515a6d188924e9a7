import re
from pathlib import Path

import numpy as np
import pytest

from robots import UrdfError, load_robot
from robots.urdf_reader import read_urdf
from robots.urdf_writer import write_urdf
from tests.broken_urdfs import BROKEN, LINKS, joint, mesh


@pytest.mark.parametrize("case", BROKEN)
def test_broken_urdf_gets_one_sentence(case: str, tmp_path: Path, capfd) -> None:  # type: ignore[no-untyped-def]
    text, expected = BROKEN[case]
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    with pytest.raises(UrdfError, match=re.escape(expected)) as caught:
        load_robot(urdf=path, base="a", tip="b")
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)
    assert caught.value.__suppress_context__ or caught.value.__context__ is None
    # No other parser has seen the file, so nothing but the error is said.
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("base", "tip", "expected"),
    [
        ("b", "a", "not below the base 'b'"),
        ("a", "c", "no link 'c' to be the tip"),
        ("a", "a", "no joint moves"),
    ],
)
def test_wrong_ends(tmp_path: Path, base: str, tip: str, expected: str) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(f"<robot>{LINKS}{joint()}</robot>")
    with pytest.raises(UrdfError, match=expected):
        load_robot(urdf=path, base=base, tip=tip)


def test_folder_missing_and_binary_file(tmp_path: Path) -> None:
    with pytest.raises(UrdfError, match="a folder"):
        read_urdf(tmp_path)
    with pytest.raises(UrdfError, match="no such file"):
        read_urdf(tmp_path / "none.urdf")
    with pytest.raises(UrdfError, match="cannot be read: File name too long"):
        read_urdf(tmp_path / ("n" * 5000))
    (tmp_path / "binary.urdf").write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(UrdfError, match="not a text file"):
        read_urdf(tmp_path / "binary.urdf")


def test_floating_joint_is_refused_in_the_chain_only(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(
        "<robot>"
        + LINKS
        + '<link name="c"/>'
        + joint(kind="floating", inside="")
        + joint("b", "c")
        + "</robot>"
    )
    assert load_robot(urdf=path, base="b", tip="c").dof == 1
    with pytest.raises(UrdfError, match="is floating"):
        load_robot(urdf=path, base="a", tip="c")


def test_mesh_is_found_through_package_path(tmp_path: Path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    stl = tmp_path / "elsewhere" / "my_package" / "meshes" / "a.stl"
    stl.parent.mkdir(parents=True)
    stl.write_text("solid\nendsolid\n")
    path = tmp_path / "urdf" / "robot.urdf"
    path.parent.mkdir()
    path.write_text(f"<robot>{mesh('package://my_package/meshes/a.stl')}</link></robot>")
    for variable in (stl.parents[2], stl.parents[1]):
        monkeypatch.setenv("ROS_PACKAGE_PATH", str(variable))
        assert read_urdf(path).links["a"].collisions[0].mesh == stl


def test_declared_but_expanded_xacro_and_comments_are_fine(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(
        '<robot xmlns:xacro="http://ros.org/wiki/xacro"><!-- ${x} <xacro:arm/> -->'
        f'{LINKS}{joint()}<gazebo><plugin name="${{p}}"/></gazebo></robot>'
    )
    assert load_robot(urdf=path).dof == 1


def test_written_urdf_reads_back_the_same(two_link_urdf: Path, tmp_path: Path) -> None:
    for source in (two_link_urdf, two_link_urdf.with_name("mixed.urdf")):
        first = read_urdf(source)
        again = tmp_path / source.name
        again.write_text(write_urdf(first))
        second = read_urdf(again)
        assert "safety_controller" not in again.read_text()
        assert list(second.links) == list(first.links)
        for name, expected in first.joints.items():
            found = second.joints[name]
            assert found.movable == expected.movable
            assert (found.parent, found.child) == (expected.parent, expected.child)
            if expected.movable:
                assert np.abs(found.origin - expected.origin).max() < 1e-15
                assert (found.lower, found.upper) == (expected.lower, expected.upper)
        for name, link in first.links.items():
            assert [s.size for s in second.links[name].collisions] == [
                s.size for s in link.collisions
            ]


def test_odd_but_usable_objects_are_noted(mixed) -> None:  # type: ignore[no-untyped-def]
    assert mixed.urdf.notes == (
        "joint 'stuck' has limits of zero width and is treated as fixed at 0.25",
    )
    assert mixed.joint_names == ("yaw", "lift", "elbow")
    assert mixed.lower[0] == -np.pi and mixed.upper[0] == np.pi
