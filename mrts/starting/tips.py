# SPDX-License-Identifier: MIT
"""The hands of a URDF, found by the names of its links and by where its chains part."""

import re
from collections.abc import Sequence

from mrts.base.formats.urdf import Urdf, UrdfJoint

FEWEST_JOINTS = 6
"""Of a chain that may be an arm."""

SIDES = {"left": ("left", "l"), "right": ("right", "r")}

LEGS = frozenset({"foot", "feet", "sole", "ankle", "leg", "toe", "hip", "knee", "wheel", "thigh", "calf"})

NEVER = frozenset({
    "finger", "fingertip", "thumb", "index", "middle", "ring", "pinky", "little", "knuckle", "jaw", "mover",
    "motor", "screw", "camera", "optical", "depth", "rgb", "imu", "sensor", "led", "accelerometer", "range",
    "visual", "collision", "shape", "skin", "dh", "safety", "head", "eye", "gaze", "itb", "torso", "chest", "logo",
    "balancing",
})  # fmt: skip
"""Words in names of links that are no hand, or only a part of one."""

TOOLS = (
    ({"tcp"}, {"tool", "0"}, {"tool", "center"}, {"grasping", "frame"}, {"tool", "frame"}, {"gripper", "frame"}),
    ({"flange"}, {"end", "effector"}, {"eef"}, {"ee"}, {"effector"}, {"tool"}, {"contact"}),
    ({"gripper"}, {"palm"}, {"hand"}, {"nub"}),
    ({"wrist"},),
)  # fmt: skip
"""Words that name a hand, the best first; all words of a set stand in the name."""

BARE = frozenset({"link", "base", "frame", "rubber", "stator", "left", "right", "l", "r"})
"""Words that may stand beside those of the last two ranks: `left_hand_link`, but not `left_hand_cover`."""

WHOLE_NAMES = 2
"""From this rank on, other words than `BARE` say that it is something else."""

BESIDE = BARE.union(*(name for kinds in TOOLS[WHOLE_NAMES:] for name in kinds))
"""Words that may stand in such a name."""


def words(name: str) -> list[str]:
    """The words of a name, in small letters: `LArm_effector` has l, arm, effector."""
    return [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", name)]


def moved_by(tree: Urdf, link: str) -> list[UrdfJoint]:
    """Joints that move a link, from the root on."""
    return [joint for joint in tree.joints_to(link) if joint.moves]


def links_beyond(tree: Urdf, link: str) -> tuple[str, ...]:
    """Links that hang from a link, however far."""
    found = [link]
    for above in found:
        found += [joint.child for joint in tree.joints.values() if joint.parent == above]
    return tuple(found[1:])


def first_link(tree: Urdf, tips: Sequence[str]) -> str:
    """Where the chains of the arms of one machine begin: past what they share, and past what no chain may hold."""
    first = tree.root
    chains = [tree.joints_to(tip) for tip in tips]
    for joint in chains[0]:
        shared = len(chains) > 1 and joint.moves and all(joint in chain for chain in chains)
        if shared or not (joint.moves or joint.type == "fixed"):
            first = joint.child
    return first


def hands(tree: Urdf) -> list[str]:
    """The links that seem to be hands, one an arm: by their names, or else where chains end or part."""
    candidates = _candidates(tree)
    named = [(link, rank) for link in candidates if (rank := _rank(link)) is not None]
    if not named:
        # a word for a hand beside others, such as that of its maker: `LeftSakePalmLink`
        kinds = TOOLS[WHOLE_NAMES]
        named = [(link, WHOLE_NAMES) for link in candidates if any(name <= {*words(link)} for name in kinds)]
    found = []
    for limb in _limbs(tree, [link for link, _ in named]):
        best = min(rank for link, rank in named if link in limb)
        chosen = (link for link, rank in named if link in limb and rank == best)
        found.append(max(chosen, key=lambda link: len(tree.joints_to(link))))
    return found or _ends(tree)


def _ends(tree: Urdf) -> list[str]:
    above = {joint.parent for joint in tree.joints.values()}
    ends = [link for link in _candidates(tree) if link not in above]
    if not ends:  # a URDF whose only end has the name of a finger
        ends = [link for link in tree.links if link not in above and len(moved_by(tree, link)) >= FEWEST_JOINTS]
    found = []
    for limb in _limbs(tree, ends):
        chains = [tree.joints_to(link) for link in limb]
        found.append([joint for joint in chains[0] if all(joint in chain for chain in chains)][-1].child)
    return found


def side_of(link: str) -> str:
    """What the name of a link says: "left", "right" or nothing."""
    return next((side for side, names in SIDES.items() if {*names} & {*words(link)}), "")


def _candidates(tree: Urdf) -> list[str]:
    """Links that enough joints move, each by a motor of its own, and whose names do not say something else."""
    found = []
    for link in tree.links:
        moving = moved_by(tree, link)
        own = not any(joint.mimic for joint in moving)
        leg = any(LEGS.intersection(words(joint.name) + words(joint.child)) for joint in moving)
        if len(moving) >= FEWEST_JOINTS and own and not leg and not NEVER.intersection(words(link)):
            found.append(link)
    return found


def _rank(link: str) -> int | None:
    given = {*words(link)}
    for rank, names in enumerate(TOOLS):
        beside = any(name <= given and (rank < WHOLE_NAMES or given - name <= BESIDE) for name in names)
        if beside:
            return rank
    return None


def _limbs(tree: Urdf, links: list[str]) -> list[list[str]]:
    """Links by arm: those that share more than half of the joints that move them."""
    limbs: list[list[str]] = []
    for link in links:
        own = moved_by(tree, link)
        for limb in limbs:
            other = moved_by(tree, limb[0])
            if 2 * len([joint for joint in own if joint in other]) > max(len(own), len(other)):
                limb.append(link)
                break
        else:
            limbs.append([link])
    return limbs
