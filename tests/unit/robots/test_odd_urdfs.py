"""URDFs as people publish them: what kinematics does not need never refuses a robot."""

import re
from pathlib import Path

import numpy as np
import pytest

from robots import Robot, UrdfError, load_robot
from robots.add import add_robot
from robots.description import find_description
from robots.urdf_reader import read_urdf
from tests.broken_urdfs import LINKS, SHAPELESS, joint
from tests.small_arms import arm, save

ENCODINGS = {
    "utf-8": ("utf-8", "utf-8", b""),
    "utf-8 with a mark": ("utf-8", "utf-8", b"\xef\xbb\xbf"),
    "latin-1": ("ISO-8859-1", "latin-1", b""),
    "windows": ("windows-1252", "cp1252", b""),
    "utf-16": ("UTF-16", "utf-16", b""),
    "utf-16, declared as utf-8": ("utf-8", "utf-16", b""),
    "utf-8, declared as utf-16": ("utf-16", "utf-8", b""),
    "unknown": ("martian", "utf-8", b""),
}


@pytest.mark.parametrize("case", ENCODINGS)
def test_a_declared_encoding_is_read(case: str, tmp_path: Path) -> None:
    declared, encoding, mark = ENCODINGS[case]
    text = f'<?xml version="1.0" encoding="{declared}"?>\n{arm(2)}'.replace('"l2"', '"é2"')
    robot = load_robot(urdf=save(tmp_path, mark + text.encode(encoding)), base="b", tip="é2")
    assert robot.tip == "é2" and robot.dof == 2


def test_characters_of_several_bytes_are_read(tmp_path: Path) -> None:
    text = '<?xml version="1.0" encoding="gb2312"?>' + arm(2).replace('"l2"', '"手臂"')
    assert load_robot(urdf=save(tmp_path, text.encode("gb2312"))).tip == "手臂"


def test_undeclared_latin_1_is_refused_with_a_hint(tmp_path: Path) -> None:
    path = save(tmp_path, arm(2).replace('"l2"', '"é"').encode("latin-1"))
    with pytest.raises(UrdfError, match="declare its encoding"):
        read_urdf(path)


@pytest.mark.parametrize(
    "head",
    [
        '<robot xmlns="http://www.ros.org">',
        '<robot xmlns:drake="http://drake.mit.edu"><drake:joint name="x"/>',
        '<robot><undeclared:joint name="x" type="odd"/>',
        '<robot><link xmlns="http://a.b" name="far"/><joint name="f" type="fixed">'
        '<parent link="far"/><child link="b"/></joint>',
    ],
)
def test_namespaces_and_prefixes_do_not_matter(head: str, tmp_path: Path) -> None:
    text = arm(3, head, limit='<limit lower="-1" upper="1" drake:acceleration="3"/>')
    robot = load_robot(urdf=save(tmp_path, text), base="b", tip="l3")
    assert robot.joint_names == ("j1", "j2", "j3")
    assert any("prefixes" in note and "drake" in note for note in robot.urdf.notes)


def test_a_prefix_on_every_element_is_one_namespace(tmp_path: Path) -> None:
    text = arm(2).replace("</", "</u:").replace("<", "<u:").replace("<u:/u:", "</u:")
    assert load_robot(urdf=save(tmp_path, text)).dof == 2


@pytest.mark.parametrize("case", SHAPELESS)
def test_a_shape_that_cannot_be_used_is_an_error_only_where_shapes_are_wanted(
    case: str, tmp_path: Path
) -> None:
    link, expected = SHAPELESS[case]
    path = save(tmp_path, f"<robot>{link}<link name='b'/>{joint()}</robot>")
    robot = load_robot(urdf=path, base="a", tip="b")
    assert robot.forward_kinematics([0.5]).shape == (1, 7)
    assert robot.sample(3, collision_free=False).shape == (3, 1)
    assert any(expected in note for note in robot.urdf.notes)
    with pytest.raises(UrdfError, match=re.escape(expected)):
        robot.in_collision([0.5])


def test_a_missing_picture_of_a_link_does_not_keep_the_robot_out(tmp_path: Path) -> None:
    hidden = '<visual><geometry><mesh filename="gone.dae"/></geometry></visual>'
    path = save(tmp_path, arm(2).replace('<link name="l1"/>', f'<link name="l1">{hidden}</link>'))
    assert not load_robot(urdf=path).in_collision([0.1, 0.2])[0]
    report = add_robot(path, "b", "l2", into=tmp_path / "robots", conf=tmp_path / "conf")
    assert any("gone.dae" in point for point in report.open_points)
    assert "gone.dae" not in (report.folder / "arm.urdf").read_text()


@pytest.mark.parametrize("rgba", ["0.1 0.2 0.3 0 1", "0.5 0.5 0.5", "", "red", "255 0 0 1"])
def test_an_odd_colour_is_a_note(rgba: str, tmp_path: Path) -> None:
    ball = (
        '<visual><geometry><sphere radius="0.1"/></geometry><material name="m"><color rgba="{}"/>'
    )
    link = f'<link name="l1">{ball.format(rgba)}</material></visual></link>'
    urdf = read_urdf(save(tmp_path, arm(2).replace('<link name="l1"/>', link)))
    assert urdf.links["l1"].visuals[0].colour is None
    assert len(urdf.notes) == 1 and "colour" in urdf.notes[0]


def test_materials_by_name_survive_being_added(tmp_path: Path) -> None:
    red = '<material name="red"><color rgba="1 0 0 1"/></material>'
    ball = '<visual><geometry><sphere radius="0.1"/></geometry><material name="red"/></visual>'
    text = arm(2, f"<robot name='arm'>{red}").replace(
        '<link name="l1"/>', f'<link name="l1">{ball}</link>'
    )
    report = add_robot(save(tmp_path, text), "b", "l2", into=tmp_path / "r", conf=tmp_path / "c")
    added = read_urdf(report.folder / "arm.urdf")
    assert added.links["l1"].visuals[0].colour == (1.0, 0.0, 0.0, 1.0)


def test_a_capsule_is_a_cylinder_between_two_balls(tmp_path: Path) -> None:
    capsule = (
        '<collision><origin xyz="0 0 1"/><geometry><capsule radius="0.1" length="0.6"/></geometry>'
        "</collision>"
    )
    text = arm(2).replace('<link name="l1"/>', f'<link name="l1">{capsule}</link>')
    shapes = read_urdf(save(tmp_path, text)).links["l1"].collisions
    assert [shape.kind for shape in shapes] == ["cylinder", "sphere", "sphere"]
    assert sorted(shape.origin[2, 3] for shape in shapes) == pytest.approx([0.7, 1.0, 1.3])
    assert not load_robot(urdf=tmp_path / "robot.urdf").in_collision([0.1, 0.2])[0]


def test_inertia_and_capacities_that_cannot_be_read_are_notes(tmp_path: Path) -> None:
    link = '<link name="l1"><inertial><mass value="heavy"/><inertia/></inertial></link>'
    limit = '<limit lower="-1" upper="1" velocity="fast" effort=""/>'
    text = arm(2, limit=limit).replace('<link name="l1"/>', link)
    robot = load_robot(urdf=save(tmp_path, text))
    assert robot.urdf.links["l1"].inertial is None
    assert np.isinf(robot.velocity_limit).all() and len(robot.urdf.notes) == 5


@pytest.mark.parametrize("number", ["2_5", "0x1p1", "1,5", "pi", "", "nan", "１", "1e", "--1"])
def test_only_numbers_are_numbers(number: str, tmp_path: Path) -> None:
    path = save(tmp_path, arm(1, limit=f'<limit lower="-1" upper="{number}"/>'))
    with pytest.raises(UrdfError, match="upper limit of joint 'j1' reads"):
        read_urdf(path)


@pytest.mark.parametrize(
    ("tag", "hint"),
    [("mujoco", "MJCF"), ("sdf", "SDFormat"), ("COLLADA", "mesh"), ("html", "web page")],
)
def test_other_formats_are_refused_with_what_to_do(tag: str, hint: str, tmp_path: Path) -> None:
    with pytest.raises(UrdfError, match=hint):
        read_urdf(save(tmp_path, f"<{tag}/>"))


def test_text_instead_of_a_path_is_said() -> None:
    for wrong in (arm(2), b"x", 3):
        with pytest.raises(UrdfError, match="expected the path"):
            load_robot(urdf=wrong)  # type: ignore[arg-type]


def test_axes_of_any_length(tmp_path: Path) -> None:
    reference = load_robot(urdf=save(tmp_path, arm(3)))
    joints = reference.sample(5)
    for axis in ("0 0 17", "0 0 1e-8", "0 0 1e200"):
        text = arm(3).replace('xyz="0 0 1"', f'xyz="{axis}"')
        robot = load_robot(urdf=save(tmp_path, text, "other.urdf"))
        difference = robot.forward_kinematics(joints) - reference.forward_kinematics(joints)
        assert np.abs(difference).max() < 1e-14


def test_huge_limits_of_a_turning_joint_are_none(tmp_path: Path) -> None:
    for limit in (
        'lower="-1e16" upper="1e16"',
        'lower="-inf" upper="inf"',
        'lower="0" upper="1e400"',
    ):
        robot = load_robot(urdf=save(tmp_path, arm(2, limit=f"<limit {limit}/>")))
        assert robot.endless.all() and robot.upper[0] == np.pi
        assert any("treated as continuous" in note for note in robot.urdf.notes)


def test_a_joint_that_slides_for_ever_is_refused_in_the_chain_only(tmp_path: Path) -> None:
    rail = (
        '<robot name="r"><link name="w"/><joint name="rail" type="prismatic"><parent link="w"/>'
        '<child link="b"/><axis xyz="1 0 0"/><limit lower="-inf" upper="1e300"/></joint>'
    )
    path = save(tmp_path, arm(2, rail))
    with pytest.raises(UrdfError, match="'rail' of the chain slides from -inf to 1e\\+300 m"):
        load_robot(urdf=path, base="w", tip="l2")
    robot = load_robot(urdf=path, base="b", tip="l2")
    assert robot.dof == 2 and robot.pinocchio()[0].nq == 2


def test_base_and_tip_may_share_names_with_joints(tmp_path: Path) -> None:
    text = f'<robot name="r">{LINKS}<link name="c"/>{joint()}{joint("b", "c")}</robot>'
    text = text.replace('name="b_c"', 'name="c"').replace('name="a_b"', 'name="a"')
    robot = load_robot(urdf=save(tmp_path, text), base="a", tip="c")
    model, frame = robot.pinocchio()
    assert model.nq == 2 and str(model.frames[frame].type) == "BODY"


def test_a_robot_from_a_file_is_not_one_of_the_names(tmp_path: Path) -> None:
    robot = load_robot(urdf=save(tmp_path, arm(7, "<robot name='panda'>")))
    assert robot.name != "panda" and robot.urdf.name == "panda"


@pytest.mark.parametrize("name", ["on", "Null", "100%", "2", "nan", "true"])
def test_names_that_a_command_line_cannot_say_are_refused_with_a_suggestion(
    name: str, tmp_path: Path
) -> None:
    path = save(tmp_path, arm(2, f"<robot name='{name}'>"))
    with pytest.raises(ValueError, match="such as --name robot_"):
        add_robot(path, "b", "l2", into=tmp_path / "r", conf=tmp_path / "c")
    assert not (tmp_path / "r").exists()


def test_any_names_survive_being_added(tmp_path: Path) -> None:
    names = {'"j1"': '"null"', '"j2"': '"j: 2 #"', '"l1"': '"on"', '"l2"': '"it&apos;s &lt;手&gt;"'}
    text = arm(3, "<robot name='A&amp;B: c'>")
    for old, new in names.items():
        text = text.replace(old, new)
    report = add_robot(save(tmp_path, text), "b", "l3", into=tmp_path / "r", conf=tmp_path / "c")
    added = Robot(find_description(report.name, tmp_path / "r"))
    assert added.joint_names == ("null", "j: 2 #", "j3") and report.name == "a_b_c"
    assert "it's <手>" in added.urdf.links and added.description.title == "A&B: c"


def test_a_missing_end_is_answered_with_a_proposal(tmp_path: Path) -> None:
    text = arm(3).replace(
        "</robot>",
        '<link name="eye"/><joint name="e" type="fixed"><parent link="l1"/><child link="eye"/>'
        "</joint></robot>",
    )
    path = save(tmp_path, text)
    for base, tip in ((None, None), ("b", None), (None, "l3")):
        with pytest.raises(ValueError, match="--base 'b' --tip 'l3'"):
            add_robot(path, base, tip, into=tmp_path / "r", conf=tmp_path / "c")
