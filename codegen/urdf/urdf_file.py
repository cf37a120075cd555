# SPDX-License-Identifier: MIT
"""Reading a URDF: only links with inertials and joints, everything else in the file is left alone.

Document types are refused (entity bombs), and a missing mass or a missing entry of an inertia is an error, not a
default. Libraries that read URDFs import all that draws them first: 1 s of each first use of a cell.
"""

from collections.abc import Iterable
from functools import lru_cache
from graphlib import CycleError, TopologicalSorter
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from mrts.base.errors import InputError, Mistakes
from mrts.base.formats.urdf import NO_LIMIT, Link, Mimic, Urdf, UrdfJoint
from mrts.base.input_file import LARGEST_NUMBER, SMALLEST_NUMBER, text_of
from mrts.base.rigid_transform import RigidTransform, rotation_from_rpy, snap_rotation

FILES_KEPT = 16
"""URDFs that are not parsed again while their text stays the same: many cells are made of a few."""

MAX_LINKS = 2000
"""Far above any robot; reading so many takes a second."""

JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
XACRO_NAMESPACE = "http://www.ros.org/wiki/xacro"
_HARMLESS = ("NS_ERR_UNDEFINED_NAMESPACE", "ERR_UNKNOWN_VERSION")
_JOINT_CHILDREN = ("parent", "child", "origin", "axis", "limit", "mimic", "dynamics")
INERTIA_KEYS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
"""Attributes of <inertia>."""


@lru_cache(maxsize=FILES_KEPT)
def parse_urdf(path: Path, content: bytes) -> Urdf:
    """Parse a URDF."""
    root = _parse(path, text_of(path, "URDF", content))
    if root.tag != "robot":
        raise InputError(path, "is not a URDF: its root element must be <robot>.", value=root.tag)
    mistakes, links, joints = Mistakes(), dict[str, Any](), dict[str, Any]()
    for tag, read, found in (("link", _link, links), ("joint", _joint, joints)):
        elements = root.findall(tag)
        if len(elements) > MAX_LINKS:
            raise InputError(path, f"has {len(elements)} <{tag}> elements; mrts reads at most {MAX_LINKS}.")
        for element in elements:
            with mistakes.noted():
                one = read(path, element)
                if one.name in found:
                    raise InputError(path, f"two {tag}s have this name.", key=f"{tag} '{one.name}'")
                found[one.name] = one
    mistakes.raise_noted()
    root_link = _root_of_tree(path, links, joints.values())
    return Urdf(root_link, links, {joint.child: joint for joint in joints.values()})


def _root_of_tree(path: Path, links: dict[str, Link], joints: Iterable[UrdfJoint]) -> str:
    """The link that hangs from no joint; an error unless joints make a tree of links."""
    parents: dict[str, str] = {}
    for joint in joints:
        for end in (joint.parent, joint.child):
            if end not in links:
                raise InputError(path, f"names a link '{end}' that is not there.", key=f"joint '{joint.name}'")
        if joint.child in parents:
            raise InputError(path, "hangs from two joints; a URDF must be a tree.", key=f"link '{joint.child}'")
        parents[joint.child] = joint.parent
    try:
        TopologicalSorter({child: [parent] for child, parent in parents.items()}).prepare()
    except CycleError as error:
        key = f"link '{error.args[1][0]}'"
        raise InputError(path, "the joints form a loop; a URDF must be a tree.", key=key) from None
    if not links:
        raise InputError(path, "has no <link>.")
    return next(link for link in links if link not in parents)


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
            raise InputError(path, "is a xacro: expand it, xacro FILE > NAME.urdf (ROS, or pip install xacrodoc).")
    return root


def _link(path: Path, link: Any) -> Link:
    name = _attribute(path, link, "name", "a <link>")
    where = f"link '{name}'"
    inertial = _only(path, where, link, "inertial")
    if inertial is None:
        return Link(name, 0.0, np.zeros((3, 3)), RigidTransform.identity())
    parts = _parts(path, where, inertial, ("origin", "mass", "inertia"))
    if "value" not in parts.get("mass", {}):
        raise InputError(path, "its <inertial> needs <mass value=…> in kg.", key=where)
    if not parts.get("inertia", {}).keys() >= {*INERTIA_KEYS}:
        raise InputError(path, f"its <inertial> needs <inertia> with {', '.join(INERTIA_KEYS)}.", key=where)
    xx, xy, xz, yy, yz, zz = (parts["inertia"][key] for key in INERTIA_KEYS)
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Link(name, parts["mass"]["value"], matrix, _origin(parts))


def _joint(path: Path, joint: Any) -> UrdfJoint:
    name = _attribute(path, joint, "name", "a <joint>")
    where = f"joint '{name}'"
    kind = _attribute(path, joint, "type", where)
    if kind not in JOINT_TYPES:
        raise InputError(path, f"must be one of {', '.join(JOINT_TYPES)}.", key=f"{where} type", value=kind)
    parts = _parts(path, where, joint, _JOINT_CHILDREN)
    for tag, attribute in (("parent", "link"), ("child", "link"), *(("mimic", "joint"),) * ("mimic" in parts)):
        if not parts.get(tag, {}).get(attribute):
            raise InputError(path, f"a <{tag} {attribute}=…> element is needed.", key=where)

    def number(tag: str, key: str, default: float = 0.0) -> float:
        return float(parts.get(tag, {}).get(key, default))

    def limit(key: str, none: float) -> float:
        given = number("limit", key, none)
        return none if abs(given) >= NO_LIMIT else given

    mimic = None
    if "mimic" in parts:
        mimic = Mimic(parts["mimic"]["joint"], number("mimic", "multiplier", 1.0), number("mimic", "offset"))
    axis = parts.get("axis", {}).get("xyz", np.array([1.0, 0.0, 0.0]))
    length = float(np.sqrt(sum(axis * axis)))
    endless = kind == "continuous"
    return UrdfJoint(
        name=name,
        type=kind,
        parent=parts["parent"]["link"],
        child=parts["child"]["link"],
        origin=_origin(parts),
        axis=axis / length if 0 < length < inf else np.zeros(3),
        lower=-inf if endless else limit("lower", -inf),
        upper=inf if endless else limit("upper", inf),
        velocity=limit("velocity", inf) or inf,
        effort=number("limit", "effort"),
        coulomb=number("dynamics", "friction"),
        viscous=number("dynamics", "damping"),
        mimic=mimic,
    )


def _origin(parts: dict[str, dict[str, Any]]) -> RigidTransform:
    p, rpy = (parts.get("origin", {}).get(key, np.zeros(3)) for key in ("xyz", "rpy"))
    return RigidTransform(snap_rotation(rotation_from_rpy(*rpy.tolist())), p)


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


_NAMES = {"link", "joint", "name", "type"}


def _parts(path: Path, where: str, element: Any, tags: tuple[str, ...]) -> dict[str, dict[str, Any]]:
    """Attributes of the children with these tags that there are, one of each; numbers are floats, three are arrays."""
    found = {tag: _only(path, where, element, tag) for tag in tags}
    return {tag: _attributes(path, f"{where}, <{tag}>", child) for tag, child in found.items() if child is not None}


def _attributes(path: Path, where: str, element: Any) -> dict[str, Any]:
    values: dict[str, Any] = {}
    # a limit may be any number: what is too large for a limit means that there is none
    largest = inf if element.tag == "limit" else LARGEST_NUMBER
    for attribute, text in element.attrib.items():
        if attribute in _NAMES:
            values[attribute] = text
            continue
        count = 3 if attribute in {"xyz", "rpy"} else 1
        try:
            numbers = [float(word) for word in text.split()]
        except ValueError:
            numbers = []
        if element.tag in {"limit", "mass"} and any(0 < abs(number) < SMALLEST_NUMBER for number in numbers):
            rule = f"must be 0, or at least {SMALLEST_NUMBER:g} in size."
            raise InputError(path, rule, key=f"{where} {attribute}", value=text)
        if "_" in text or len(numbers) != count or not all(abs(number) <= largest for number in numbers):
            wanted = "a finite number" if count == 1 else f"{count} finite numbers with spaces between them"
            raise InputError(path, f"must be {wanted}.", key=f"{where} {attribute}", value=text)
        values[attribute] = numbers[0] if count == 1 else np.array(numbers)
    return values
