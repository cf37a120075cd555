# SPDX-License-Identifier: MIT
"""Reading a URDF: only links with inertials and joints, everything else in the file is left alone.

Document types are refused (entity bombs), and a missing mass or a missing entry of an inertia is an error, not a
default. Libraries that read URDFs import all that draws them first: 1 s of each first use of a cell.
"""

from functools import lru_cache
from math import inf, nan
from pathlib import Path
from typing import Any

from lxml import etree
from mrts_codegen.urdf.urdf_elements import INERTIA_KEYS, Link, Urdf, UrdfJoint, joint_of, link_of

from mrts.base.errors import InputError, Mistakes
from mrts.base.input_file import LARGEST_NUMBER, SMALLEST_NUMBER, text_of

FILES_KEPT = 16
"""URDFs that are not parsed again while their text stays the same: many cells are made of a few."""

MAX_LINKS = 2000
"""Far above any robot; reading so many takes a second."""

JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
XACRO_NAMESPACE = "http://www.ros.org/wiki/xacro"
_HARMLESS = ("NS_ERR_UNDEFINED_NAMESPACE", "ERR_UNKNOWN_VERSION")
_JOINT_CHILDREN = ("parent", "child", "origin", "axis", "limit", "mimic", "dynamics")


def parse_urdf(path: Path, content: bytes) -> Urdf:
    """Parse a URDF.

    Args:
        path: The file, for messages.
        content: Its bytes.

    Returns:
        Its links and joints.

    Raises:
        InputError: If it is not XML, not a URDF, an unexpanded xacro, or holds a value that is no number.
    """
    return _parsed(path, text_of(path, "URDF", content))


def mesh_names(path: Path, content: bytes) -> list[str]:
    """Files of meshes that a URDF names, each once; arguments as `parse_urdf`, which has read it."""
    meshes = _parse(path, text_of(path, "URDF", content)).iter("mesh")
    return list(dict.fromkeys(str(mesh.get("filename") or "") for mesh in meshes))


@lru_cache(maxsize=FILES_KEPT)
def _parsed(path: Path, text: str) -> Urdf:
    root = _parse(path, text)
    if root.tag != "robot":
        raise InputError(path, "is not a URDF: its root element must be <robot>.", value=root.tag)
    _check_names_differ(path, root)
    mistakes = Mistakes()
    links, joints = [], []
    for link in root.findall("link"):
        with mistakes.noted():
            links.append(_checked_link(path, link))
    for joint in root.findall("joint"):
        with mistakes.noted():
            joints.append(_checked_joint(path, joint))
    mistakes.raise_noted()
    return Urdf(tuple(links), tuple(joints))


def _parse(path: Path, text: str) -> Any:
    # Undeclared prefixes (gazebo extensions) and a version 0.0 are common and harmless; anything worse is refused.
    parser = etree.XMLParser(resolve_entities=False, no_network=True, recover=True)
    try:
        root = etree.fromstring(text.encode(), parser)
    except etree.XMLSyntaxError:  # nothing at all could be recovered
        root = None
    fatal = [error for error in parser.error_log if error.type_name not in _HARMLESS]
    if root is None or fatal:
        place = f" at line {fatal[0].line}: {fatal[0].message}" if fatal else ""
        raise InputError(path, f"is not well-formed XML{place}.")
    if root.getroottree().docinfo.doctype:
        raise InputError(path, "declares a document type or an entity; a URDF needs neither. Remove it.")
    for element in root.iter(etree.Element):
        if str(element.tag).startswith(("xacro:", f"{{{XACRO_NAMESPACE}}}")) or any(
            mark in value for value in element.attrib.values() for mark in ("${", "$(")
        ):
            raise InputError(path, "is an unexpanded xacro. Call it NAME.xacro, and mrts expands it (extra 'xacro').")
    return root


def _checked_link(path: Path, link: Any) -> Link:
    name = _attribute(path, link, "name", "a <link>")
    inertial = _only(path, f"link '{name}'", link, "inertial")
    return link_of(name, None if inertial is None else _checked_inertial(path, name, inertial))


def _checked_joint(path: Path, joint: Any) -> UrdfJoint:
    name = _attribute(path, joint, "name", "a <joint>")
    where = f"joint '{name}'"
    kind = _attribute(path, joint, "type", where)
    if kind not in JOINT_TYPES:
        raise InputError(path, f"must be one of {', '.join(JOINT_TYPES)}.", key=f"{where} type", value=kind)
    for tag in _JOINT_CHILDREN:
        child = _only(path, where, joint, tag)
        if child is not None:
            _check_numbers(path, where, child)
        elif tag in {"parent", "child"}:
            raise InputError(path, f"a <{tag} link=…> element is needed.", key=where)
    for tag in ("parent", "child"):
        _attribute(path, joint.find(tag), "link", where)
    if joint.find("mimic") is not None:
        _attribute(path, joint.find("mimic"), "joint", f"{where}, <mimic>")
    return joint_of(joint)


def _check_names_differ(path: Path, root: Any) -> None:
    for tag in ("link", "joint"):
        elements = root.findall(tag)
        if len(elements) > MAX_LINKS:
            raise InputError(path, f"has {len(elements)} <{tag}> elements; mrts reads at most {MAX_LINKS}.")
        seen: set[str | None] = set()
        for element in elements:
            name = element.get("name")
            if name in seen:
                raise InputError(path, f"two {tag}s have this name.", key=f"{tag} '{name}'")
            seen.add(name)


def _checked_inertial(path: Path, link: str, inertial: Any) -> Any:
    where = f"link '{link}'"
    mass, inertia = (_only(path, where, inertial, tag) for tag in ("mass", "inertia"))
    if mass is None or mass.get("value") is None:
        raise InputError(path, "its <inertial> needs <mass value=…> in kg.", key=where)
    if inertia is None or any(inertia.get(key) is None for key in INERTIA_KEYS):
        raise InputError(path, f"its <inertial> needs <inertia> with {', '.join(INERTIA_KEYS)}.", key=where)
    for child in inertial:
        _check_numbers(path, where, child)
    return inertial


def _only(path: Path, where: str, element: Any, tag: str) -> Any:
    found = element.findall(tag)
    if len(found) > 1:
        raise InputError(path, f"has {len(found)} <{tag}> elements; one belongs here.", key=where)
    return found[0] if found else None


def _attribute(path: Path, element: Any, attribute: str, where: str) -> str:
    value = element.get(attribute)
    if not value:
        raise InputError(path, f"a '{attribute}' attribute is needed.", key=where)
    return str(value)


_COUNTS = {"xyz": 3, "rpy": 3}
_NAMES = {"link", "joint", "name", "type"}


def _check_numbers(path: Path, where: str, element: Any) -> None:
    if not isinstance(element.tag, str):  # a comment
        return
    for attribute, text in element.attrib.items():
        if attribute in _NAMES:
            continue
        words = text.split()
        count = _COUNTS.get(attribute, 1)
        # a limit may be any number: what is too large for a limit means that there is none
        largest = inf if element.tag == "limit" else LARGEST_NUMBER
        try:
            sizes = [abs(float(word)) for word in words]
        except ValueError:
            sizes = [nan]
        if element.tag in {"limit", "mass"} and any(0 < size < SMALLEST_NUMBER for size in sizes):
            rule = f"must be 0, or at least {SMALLEST_NUMBER:g} in size."
            raise InputError(path, rule, key=f"{where}, <{element.tag}> {attribute}", value=text)
        finite = "_" not in text and all(size <= largest for size in sizes)
        if not finite or len(words) != count:
            wanted = "a finite number" if count == 1 else f"{count} finite numbers with spaces between them"
            raise InputError(path, f"must be {wanted}.", key=f"{where}, <{element.tag}> {attribute}", value=text)
