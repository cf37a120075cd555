# SPDX-License-Identifier: MIT
"""Reading a URDF: only links with inertials and joints, everything else in the file is left alone.

Document types are refused (entity bombs), and a missing mass or a missing entry of an inertia is an error, not a
default. Libraries that read URDFs import all that draws them first: 1 s of each first use of a cell.
"""

from collections import Counter
from functools import lru_cache
from graphlib import CycleError, TopologicalSorter
from math import inf, nan
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from mrts.base.arrays import Array
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


def parse_urdf(path: Path, content: bytes) -> Urdf:
    """Parse a URDF."""
    links, joints = _parsed(path, text_of(path, "URDF", content))
    return Urdf(_root_of_tree(path, links, joints), links, {joint.child: joint for joint in joints})


@lru_cache(maxsize=FILES_KEPT)
def _parsed(path: Path, text: str) -> tuple[dict[str, Link], list[UrdfJoint]]:
    root = _parse(path, text)
    if root.tag != "robot":
        raise InputError(path, "is not a URDF: its root element must be <robot>.", value=root.tag)
    _check_names_differ(path, root)
    mistakes = Mistakes()
    links, joints = {}, []
    for link in root.findall("link"):
        with mistakes.noted():
            read = _link(path, link)
            links[read.name] = read
    for joint in root.findall("joint"):
        with mistakes.noted():
            joints.append(_joint(path, joint))
    mistakes.raise_noted()
    return links, joints


def _root_of_tree(path: Path, links: dict[str, Link], joints: list[UrdfJoint]) -> str:
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
    mass, inertia = (_only(path, where, inertial, tag) for tag in ("mass", "inertia"))
    if mass is None or mass.get("value") is None:
        raise InputError(path, "its <inertial> needs <mass value=…> in kg.", key=where)
    if inertia is None or any(inertia.get(key) is None for key in INERTIA_KEYS):
        raise InputError(path, f"its <inertial> needs <inertia> with {', '.join(INERTIA_KEYS)}.", key=where)
    for child in inertial:
        _check_numbers(path, where, child)
    xx, xy, xz, yy, yz, zz = (float(inertia.get(key)) for key in INERTIA_KEYS)
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Link(name, float(mass.get("value")), matrix, _origin(inertial))


def _joint(path: Path, joint: Any) -> UrdfJoint:
    name = _attribute(path, joint, "name", "a <joint>")
    where = f"joint '{name}'"
    kind = _attribute(path, joint, "type", where)
    if kind not in JOINT_TYPES:
        raise InputError(path, f"must be one of {', '.join(JOINT_TYPES)}.", key=f"{where} type", value=kind)
    parts = {}
    for tag in _JOINT_CHILDREN:
        parts[tag] = child = _only(path, where, joint, tag)
        if child is not None:
            _check_numbers(path, where, child)
        elif tag in {"parent", "child"}:
            raise InputError(path, f"a <{tag} link=…> element is needed.", key=where)
    parent, below = (_attribute(path, parts[tag], "link", where) for tag in ("parent", "child"))

    def number(tag: str, key: str, default: float = 0.0) -> float:
        return default if parts[tag] is None else float(parts[tag].get(key, default))

    def limit(key: str, none: float) -> float:
        given = number("limit", key, none)
        return none if abs(given) >= NO_LIMIT else given

    mimic = None
    if parts["mimic"] is not None:
        leader = _attribute(path, parts["mimic"], "joint", f"{where}, <mimic>")
        mimic = Mimic(leader, number("mimic", "multiplier", 1.0), number("mimic", "offset"))
    axis = _vector(None if parts["axis"] is None else parts["axis"].get("xyz"), (1.0, 0.0, 0.0))
    length = float(np.sqrt(sum(axis * axis)))
    endless = kind == "continuous"
    return UrdfJoint(
        name=name,
        type=kind,
        parent=parent,
        child=below,
        origin=_origin(joint),
        axis=axis / length if 0 < length < inf else np.zeros(3),
        lower=-inf if endless else limit("lower", -inf),
        upper=inf if endless else limit("upper", inf),
        velocity=limit("velocity", inf) or inf,
        effort=number("limit", "effort"),
        coulomb=number("dynamics", "friction"),
        viscous=number("dynamics", "damping"),
        mimic=mimic,
    )


def _origin(element: Any) -> RigidTransform:
    origin = element.find("origin")
    if origin is None:
        return RigidTransform.identity()
    p, rpy = (_vector(origin.get(key), (0.0, 0.0, 0.0)) for key in ("xyz", "rpy"))
    return RigidTransform(snap_rotation(rotation_from_rpy(*rpy.tolist())), p)


def _vector(text: str | None, default: tuple[float, ...]) -> Array:
    return np.array(default if text is None else [float(word) for word in text.split()])


def _check_names_differ(path: Path, root: Any) -> None:
    for tag in ("link", "joint"):
        elements = root.findall(tag)
        if len(elements) > MAX_LINKS:
            raise InputError(path, f"has {len(elements)} <{tag}> elements; mrts reads at most {MAX_LINKS}.")
        for name, count in Counter(element.get("name") for element in elements).items():
            if count > 1:
                raise InputError(path, f"two {tag}s have this name.", key=f"{tag} '{name}'")


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


def _check_numbers(path: Path, where: str, element: Any) -> None:
    if not isinstance(element.tag, str):  # a comment
        return
    for attribute, text in element.attrib.items():
        if attribute in _NAMES:
            continue
        words = text.split()
        count = 3 if attribute in {"xyz", "rpy"} else 1
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
