"""Small arms as URDF texts, and files of them."""

from pathlib import Path

from tests.broken_urdfs import LIMIT

__all__ = ["LIMIT", "arm", "save"]

AXES = ("0 0 1", "0 1 0", "1 0 0")


def arm(
    count: int, head: str = "<robot name='arm'>", kind: str = "revolute", limit: str = LIMIT
) -> str:
    """An arm of `count` joints j1, j2, ... from b over l1, l2, ..., its axes z, y, x in turn."""
    parts = [head, '<link name="b"/>']
    for k in range(count):
        above = f"l{k}" if k else "b"
        parts.append(
            f'<link name="l{k + 1}"/><joint name="j{k + 1}" type="{kind}">'
            f'<origin xyz="0.1 0.02 0.2" rpy="0.3 0.2 0.1"/><parent link="{above}"/>'
            f'<child link="l{k + 1}"/><axis xyz="{AXES[k % 3]}"/>{limit}</joint>'
        )
    return "".join([*parts, "</robot>"])


def save(folder: Path, text: str | bytes, name: str = "robot.urdf") -> Path:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path
