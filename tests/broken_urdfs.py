"""URDFs with one fault each, and a word that the error must say."""

LINKS = '<link name="a"/><link name="b"/>'
LIMIT = '<limit lower="-1" upper="1" velocity="1" effort="1"/>'


def joint(parent: str = "a", child: str = "b", kind: str = "revolute", inside: str = LIMIT) -> str:
    return (
        f'<joint name="{parent}_{child}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/>{inside}</joint>'
    )


def pair(inside: str, kind: str = "revolute") -> str:
    """Two links and the joint between them."""
    return f"<robot>{LINKS}{joint(kind=kind, inside=inside)}</robot>"


def mesh(name: str) -> str:
    return f'<link name="a"><collision><geometry><mesh filename="{name}"/></geometry></collision>'


BROKEN = {
    "bad XML": (f"<robot name='r'>{LINKS}", "not well-formed XML"),
    "missing link": ("<robot>" + LINKS + joint(child="c") + "</robot>", "child link 'c'"),
    "loop": ("<robot>" + LINKS + joint() + joint("b", "a") + "</robot>", "loop"),
    "two parents": (
        f"<robot>{LINKS}<link name='c'/>"
        + joint()
        + joint("c", "b")
        + joint("a", "c")
        + "</robot>",
        "child of both",
    ),
    "two roots": (f"<robot>{LINKS}</robot>", "2 root links"),
    "NaN limit": (
        pair('<limit lower="nan" upper="1"/>'),
        "lower limit of joint 'a_b' reads 'nan'",
    ),
    "lower above upper": (
        pair('<limit lower="2" upper="1"/>'),
        "lower limit 2 above the upper 1",
    ),
    "no limit": (pair(""), "has no <limit>"),
    "zero axis": (
        pair(LIMIT + '<axis xyz="0 0 0"/>'),
        "zero axis",
    ),
    "two numbers": (
        pair(LIMIT + '<origin xyz="0 0"/>'),
        "expected 3 finite numbers",
    ),
    "unknown joint type": (pair(LIMIT, "screw"), "type 'screw'"),
    "empty file": ("", "empty"),
    "not a robot": ("<sdf/>", "expected <robot>"),
    "no links": ("<robot/>", "no <link>"),
    "same name twice": ("<robot><link name='a'/><link name='a'/></robot>", "same name"),
    "mimics nothing": (
        pair(LIMIT + '<mimic joint="c"/>'),
        "mimics 'c'",
    ),
    "mimics itself": (
        pair(LIMIT + '<mimic joint="a_b"/>'),
        "in a circle",
    ),
    "xacro macro": (f"<robot><xacro:arm/>{LINKS}</robot>", "xacro robot.urdf >"),
    "xacro value": ("<robot><link name='${name}'/></robot>", "xacro robot.urdf >"),
}

# Links whose shapes cannot be used, which kinematics does not mind, and what the note says.
SHAPELESS = {
    "mesh missing": (mesh("gone.stl") + "</link>", "mesh 'gone.stl'"),
    "package missing": (mesh("package://none/gone.stl") + "</link>", "ROS_PACKAGE_PATH"),
    "web address": (mesh("https://a.b/c.stl") + "</link>", "only files and package://"),
    "no geometry": ("<link name='a'><collision/></link>", "has no <geometry>"),
    "nothing in it": (
        "<link name='a'><collision><geometry/></collision></link>",
        "no box, cylinder, sphere, capsule or mesh, but nothing",
    ),
    "unknown shape": (
        "<link name='a'><collision><geometry><cone/></geometry></collision></link>",
        "but <cone>",
    ),
    "negative size": (
        "<link name='a'><collision><geometry><sphere radius='-1'/></geometry></collision></link>",
        "negative size",
    ),
}
