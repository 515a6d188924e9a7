"""From the bytes of a URDF file to its elements: encodings, namespaces, and what is no URDF."""

from __future__ import annotations

import codecs
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from xml.parsers import expat

from robots.errors import UrdfError

_BYTE_ORDER_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),  # before UTF-16, whose mark it begins with
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_DECLARED = re.compile(rb"""^\s*<\?xml[^>]*?\sencoding\s*=\s*["']([A-Za-z0-9._-]+)["']""")
# Other descriptions of robots, by their outermost element, and what to do about each.
_OTHER_FORMATS = {
    "mujoco": "an MJCF model of MuJoCo; take the robot's URDF, which its maker's description "
    "package has, or convert it",
    "mujocoinclude": "a part of an MJCF model of MuJoCo; take the robot's URDF",
    "sdf": "an SDFormat model of Gazebo; take the robot's URDF or convert it",
    "COLLADA": "a COLLADA mesh; give the URDF that names it",
    "html": "a web page; download the raw file instead",
}


@dataclass(frozen=True)
class Document:
    """A parsed URDF file.

    Attributes:
        text: What the file says, with line feeds as line ends.
        root: Its outermost element; elements and attributes with a foreign prefix are left out.
        notes: What was odd but could be dealt with, one sentence each.
    """

    text: str
    root: ElementTree.Element
    notes: tuple[str, ...]


def read_document(path: Path) -> Document:
    """Read a URDF file in whatever encoding it declares.

    Raises:
        UrdfError: With one sentence, if it cannot be read or is no URDF.
    """
    text, notes = _decoded(path, _read_bytes(path))
    if not text.strip():
        raise UrdfError(f"{path}: the file is empty")
    if "<" not in text:
        raise UrdfError(f"{path}: not a text file with elements, so not a URDF")
    root = _parsed(path, text)
    own, _, tag = root.tag.rpartition(":")
    if tag != "robot":
        raise _other_format(path, root.tag)
    if has_xacro(root):
        raise xacro_error(path)
    if prefixes := _drop_foreign(root, own):
        listed = ", ".join(sorted(prefixes))
        notes.append(f"elements and attributes with the prefixes {listed} are left out")
    if root.find("link") is None:
        raise UrdfError(f"{path}: has no <link>, expected at least one")
    return Document(text, root, tuple(notes))


def has_xacro(root: ElementTree.Element) -> bool:
    """Whether macros are left where they matter: among links and joints, or inside them."""
    if any(child.tag.startswith("xacro:") for child in root):
        return True
    parts = [part for child in root if child.tag in ("link", "joint") for part in child.iter()]
    return any(
        part.tag.startswith("xacro:")
        or any("${" in value or "$(" in value for value in part.attrib.values())
        for part in parts
    )


def xacro_error(path: Path) -> UrdfError:
    """Say that a file is a xacro source."""
    return UrdfError(
        f"{path}: has xacro macros left in it, so it is a source of a URDF and not a URDF; "
        f"expand it first: xacro {path.name} > robot.urdf"
    )


def _read_bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except IsADirectoryError:
        raise UrdfError(f"{path}: a folder, not a URDF file; give the file inside it") from None
    except FileNotFoundError:
        raise UrdfError(f"{path}: no such file") from None
    except OSError as error:
        raise UrdfError(f"{path}: cannot be read: {error.strerror}") from None
    except ValueError:  # a NUL in the name
        raise UrdfError(f"{str(path)!r}: not the name of a file") from None


def _decoded(path: Path, data: bytes) -> tuple[str, list[str]]:
    """Text of a file by its byte order mark, else by its declaration, else as UTF-8."""
    match = _DECLARED.match(data)
    declared = match[1].decode("ascii") if match else "utf-8"
    encoding = next((name for mark, name in _BYTE_ORDER_MARKS if data.startswith(mark)), declared)
    notes: list[str] = []
    try:
        unknown = not codecs.lookup(encoding)._is_text_encoding
    except LookupError:
        unknown = True
    # A declaration that can be read byte by byte is not one of UTF-16 or UTF-32.
    if unknown or (match and encoding.lower().replace("_", "-").startswith(("utf-16", "utf-32"))):
        notes.append(f"the file declares the encoding {declared} and is read as UTF-8")
        encoding = "utf-8"
    try:
        text = data.decode(encoding)
    except (UnicodeDecodeError, UnicodeError):
        hint = "" if match else "; if it is one, declare its encoding in the first line"
        raise UrdfError(f"{path}: not a text file in {encoding}, so not a URDF{hint}") from None
    return text.replace("\r\n", "\n").replace("\r", "\n"), notes


def _parsed(path: Path, text: str) -> ElementTree.Element:
    """Elements of a text, with tags as they are written.

    URDF knows no namespaces, and files come with default ones or with prefixes that nothing
    declares; so the parser is one that takes a prefix for a part of the name.
    """
    builder = ElementTree.TreeBuilder()
    parser = expat.ParserCreate("utf-8")  # whatever the declaration says: the text is decoded
    parser.buffer_text = True
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(text.encode("utf-8"), True)
        root: ElementTree.Element = builder.close()
    except expat.ExpatError as error:
        # A source of macros need not be well-formed.
        if "<xacro:" in text:
            raise xacro_error(path) from None
        raise UrdfError(f"{path}: not well-formed XML: {error}") from None
    except (ValueError, AssertionError) as error:  # lone surrogates, elements left open
        raise UrdfError(f"{path}: not readable as XML: {error}") from None
    return root


def _other_format(path: Path, tag: str) -> UrdfError:
    what = _OTHER_FORMATS.get(tag)
    if what is not None:
        return UrdfError(f"{path}: not a URDF, expected <robot>, but {what}")
    return UrdfError(f"{path}: the outermost element is <{tag}>, expected <robot>")


def _drop_foreign(root: ElementTree.Element, own: str) -> set[str]:
    """Remove elements and attributes of other prefixes than `own`; return those prefixes."""
    dropped: set[str] = set()
    waiting = [root]
    while waiting:
        element = waiting.pop()
        element.tag = element.tag.rpartition(":")[2]
        for key in list(element.attrib):
            prefix, colon, plain = key.rpartition(":")
            if not colon and key != "xmlns":
                continue
            value = element.attrib.pop(key)
            if colon and prefix == own:
                element.attrib.setdefault(plain, value)
            elif colon and prefix not in ("xmlns", "xml"):
                dropped.add(prefix)
        for child in list(element):
            prefix, colon, _ = child.tag.rpartition(":")
            if colon and prefix != own:
                element.remove(child)
                dropped.add(prefix)
            else:
                waiting.append(child)
    return dropped
