# SPDX-License-Identifier: MIT
"""The least distance between arms, object and surroundings along a motion, its samples and between them."""

from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError, MotionError, Progress, Remark, check_type, require_extra
from mrts.base.formats.record import dumped
from mrts.base.rigid_transform import RigidTransform
from mrts.cell.cell import Cell
from mrts.cell.cell_change import machine_of
from mrts.cell.generation import urdf_of
from mrts.cell.record import BodyShape, mesh_surface
from mrts.cell.remarks import COLLISIONS_UNKNOWN, NO_COLLISIONS
from mrts.cell.robot import Robot
from mrts.following.bodies import body_poses, mesh_file, posed_urdf, reading_meshes
from mrts.following.coordinate import coordinate
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.denser_motion import between_samples
from mrts.following.tracking import random_starts
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion

RESOLUTION = 1e-3
"""The least distance between the samples is found to within this [m], or `SHARE` of it."""

SHARE = 0.02

POSES = 64
"""Random postures at which links of one machine are looked at: those that overlap at all of them belong together."""

PARALLEL, MEETING = 1e-6, 1e-3
"""Sine of the angle between axes below which they are parallel, and distance [m] below which others meet."""

FLAT = 1e-6
"""Least side of the box that stands for a mesh without volume [m]."""


@dataclass(frozen=True, eq=False)
class Clearance:
    """How near bodies of a cell come to each other along a motion.

    Attributes:
        distance: The least one, negative where they overlap: the depth [m]; infinity where no pair is looked at.
        pair: Between which, as `left/forearm`, `object` or the name of an obstacle.
        time: When, in the motion's time [s].
        points: On each of the two the point nearest to the other, world, Shape (2, 3) [m].
        distances: The least one at each sample of the motion, Shape (N,) [m].
        unseen: What was not looked at because nothing gives its shape.
        left_out: Pairs of links of one machine that overlap in every posture.
    """

    distance: float
    pair: tuple[str, str] | None
    time: float | None
    points: Array | None
    distances: Array
    unseen: tuple[str, ...]
    left_out: tuple[tuple[str, str], ...]

    @property
    def collides(self) -> bool:
        """Whether two bodies overlap."""
        return self.distance < 0

    def sentence(self) -> str:
        """The least distance, or the depth, between what, and when."""
        if self.pair is None or self.time is None:
            return "no two bodies with shapes can come near each other"
        one, other = self.pair
        size = f"{1e3 * abs(self.distance):.3g} mm"
        if self.collides:
            return f"{one} and {other} collide at t = {self.time:.4g} s: they overlap by {size}"
        return f"the least distance is {size}, between {one} and {other} at t = {self.time:.4g} s"

    def at_speed(self, c: float) -> "Clearance":
        """Of the same motion played c times as fast."""
        return self if self.time is None else replace(self, time=self.time / c)

    def remarks(self) -> tuple[Remark, ...]:
        """What is to say of it: a collision as a hint, and what was not looked at."""
        said = list[Remark]()
        if self.pair:
            told = Remark.hint("collision", self.sentence()), Remark.assumed("clearance", self.sentence())
            said.append(told[0 if self.collides else 1])
        if self.unseen:
            text = f"collisions of {', '.join(self.unseen)} are not looked at: nothing gives a shape"
            said.append(Remark.assumed(COLLISIONS_UNKNOWN, text))
        return tuple(said)

    def to_json(self) -> dict[str, Any]:
        """Distance, pair, time, points, and what was not looked at, as values of JSON."""
        found = dumped(self) | {"distance": self.distance if self.pair else None}
        return {name: value for name, value in found.items() if name != "distances"}


def clearance(cell: Cell, motion: ObjectMotion | JointTable | CoordinatedMotion) -> Clearance:
    """The least distance between bodies of a cell along a motion: links of all arms, the object, the surroundings.

    Between the samples it is found to within 1 mm, or 2 % of it, on the path that the joints take there. Pairs that are
    left out: bodies that do not move against each other; links on either side of a joint, or of two whose axes meet;
    the object and the last links of the arms that hold it; links of one machine that overlap in every posture.

    Args:
        cell: The cell, with the folder of its URDFs (`Cell.folder`).
        motion: As in `mrts.scale`.

    Raises:
        InputError: If coal is not installed, a mesh cannot be read, or it is not known where the URDFs are.
        MotionError: If the arms cannot follow the motion.
    """
    check_type("cell", cell, Cell)
    return CollisionModel(cell).clearance(coordinate(cell, motion))


def clearance_remarks(
    cell: Cell, motion: ObjectMotion | JointTable | CoordinatedMotion, progress: Progress = lambda _done, _total: None
) -> tuple[Clearance | None, tuple[Remark, ...]]:
    """As `clearance`, None where that raises an error, and what is to say of it.

    `progress` is told how many samples are looked at.
    """
    try:
        near = CollisionModel(cell).clearance(coordinate(cell, motion), progress)
    except (InputError, MotionError) as error:
        return None, (Remark.assumed(COLLISIONS_UNKNOWN, f"{NO_COLLISIONS}. {error}"),)
    return near, near.remarks()


@dataclass(frozen=True, eq=False)
class Shape:
    """A shape that a body carries.

    Attributes:
        name: As messages give it.
        arm: Which one it is of; the object is one more, the world another.
        body: Which of its bodies, 0 the base; of the object and of the world 0.
        geometry: Of coal.
        pose: Its frame in that of the body.
        center: Of a ball around it, in the body's frame, Shape (3,) [m].
        radius: Of that ball [m].
    """

    name: str
    arm: int
    body: int
    geometry: Any
    pose: RigidTransform
    center: Array
    radius: float


@dataclass(frozen=True, eq=False)
class _Poses:
    """Where all bodies of a cell are: of each arm its base and what its joints move, then the object, then the world.

    Attributes:
        time: Shape (K,) [s].
        R: Shape (K, B, 3, 3).
        p: Shape (K, B, 3) [m].
        rates: Of the joints, and the object's linear and angular speed, Shape (K, m + 2).
        changes: Of these rates, likewise.
        bounds: Distances between pairs, or less than them, Shape (K, P) [m].
        exact: Which of them are distances, Shape (K, P).
    """

    time: Array
    R: Array
    p: Array
    rates: Array
    changes: Array
    bounds: Array
    exact: NDArray[np.bool_]


class CollisionModel:
    """The shapes of a cell's bodies, and which pairs of them are looked at.

    Args:
        cell: The cell.

    Raises:
        InputError: As `clearance`.
    """

    def __init__(self, cell: Cell) -> None:
        coal = coal_module()
        self._cell, arms, shapes = cell, len(cell.robots), list[Shape]()
        for arm, robot in enumerate(cell.robots):
            shapes += _link_shapes(robot, arm, cell.folder)
        seen = {shape.arm for shape in shapes}
        unseen = [f"robot '{robot.name}'" for arm, robot in enumerate(cell.robots) if arm not in seen]
        if cell.object_shape is None:
            unseen.append("the object")
        else:
            shapes.append(_record_shape("object", arms, cell, cell.object_shape))
        shapes += [_record_shape(str(one.name), arms + 1, cell, one, hollow=True) for one in cell.surroundings]
        self._shapes, self.unseen = shapes, tuple(unseen)
        first = np.cumsum([0, *(len(robot.joints) + 1 for robot in cell.robots), 1])  # of the bodies in `_Poses`
        self._bodies = np.array([first[shape.arm] + shape.body for shape in shapes], dtype=int)
        self._centers = np.array([shape.center for shape in shapes]).reshape(-1, 3)
        self._radii = np.array([shape.radius for shape in shapes])
        self._coal, self._request, self._result = coal, coal.DistanceRequest(), coal.DistanceResult()
        candidates = [(a, b) for a, b in combinations(range(len(shapes)), 2) if self._can_collide(shapes[a], shapes[b])]
        self._set_pairs(candidates)
        always = self._always_overlap()
        self.left_out = tuple(self._names(pair) for pair in np.flatnonzero(always).tolist())
        self._set_pairs([pair for pair, left in zip(candidates, always, strict=True) if not left])

    def clearance(self, motion: CoordinatedMotion, progress: Progress = lambda _done, _total: None) -> Clearance:
        """The least distance along a motion of this cell, which may have other postures than the model's."""
        found = self._poses(motion)
        own = self._look(found, progress)
        while len(between := self._to_look_between(found, motion.q)):
            time = (found.time[between] + found.time[between + 1]) / 2
            more = self._poses(between_samples(self._cell, motion, time), slice(1, -1))
            self._look(more)
            order = np.argsort(np.concatenate([found.time, more.time]), kind="stable")
            merged = {key: np.concatenate([of, getattr(more, key)])[order] for key, of in vars(found).items()}
            found = _Poses(**merged)
        nothing = Clearance(np.inf, None, None, None, own, self.unseen, self.left_out)
        if not self._pairs.size:
            return nothing
        sample, pair = np.unravel_index(int(np.argmin(found.bounds)), found.bounds.shape)
        distance = self._distance(found, int(sample), int(pair))
        points = np.array([self._result.getNearestPoint1(), self._result.getNearestPoint2()])
        when = float(found.time[sample])
        return replace(nothing, distance=distance, pair=self._names(int(pair)), time=when, points=points)

    def _one_machine(self, one: Shape, other: Shape) -> bool:
        robots = self._cell.robots
        if max(one.arm, other.arm) >= len(robots):
            return False
        return one.arm == other.arm or robots[other.arm].name in machine_of(self._cell, robots[one.arm].name)

    def _can_collide(self, one: Shape, other: Shape) -> bool:
        """Whether two shapes move against each other, are no neighbours in an arm, and do not hold each other.

        The other is of the same arm or of a later one.
        """
        robots, arms = self._cell.robots, len(self._cell.robots)
        k, m = one.body, other.body
        stands = [of.arm > arms or (of.arm < arms and of.body == 0) for of in (one, other)]
        if all(stands) or (one.arm, k) == (other.arm, m):
            return False
        if other.arm == arms:  # the object and a hand
            return k != len(robots[one.arm].joints)
        if not self._one_machine(one, other) or (one.arm != other.arm and k * m > 0):
            return True
        return not _are_neighbours(robots[one.arm if k > m else other.arm], *sorted((k, m)))

    def _set_pairs(self, pairs: list[tuple[int, int]]) -> None:
        self._pairs = np.array(pairs, dtype=int).reshape(-1, 2)
        geometries = [shape.geometry for shape in self._shapes]
        self._compute = [self._coal.ComputeDistance(geometries[a], geometries[b]) for a, b in pairs]

    def _names(self, pair: int) -> tuple[str, str]:
        a, b = self._pairs[pair]
        return self._shapes[a].name, self._shapes[b].name

    def _always_overlap(self) -> NDArray[np.bool_]:
        """Pairs of links of one machine that overlap at all of the random postures, Shape (P,)."""
        postures = [random_starts(robot, POSES, seed) for seed, robot in enumerate(self._cell.robots)]
        q = np.concatenate(postures, axis=1)
        still, unturned = np.zeros((POSES, 3)), np.broadcast_to(np.eye(3), (POSES, 3, 3))
        poses = self._placed(np.arange(float(POSES)), q, still, unturned)
        return np.array(
            [
                self._one_machine(self._shapes[a], self._shapes[b])
                and all(poses.bounds[k, pair] < 0 and self._distance(poses, k, pair) < 0 for k in range(POSES))
                for pair, (a, b) in enumerate(self._pairs)
            ],
            dtype=bool,
        )

    def _poses(self, motion: CoordinatedMotion, chosen: slice = slice(None)) -> _Poses:
        of = motion.object
        time, q, p, R = (each[chosen] for each in (of.time, motion.q, of.position, of.rotation))
        rates, changes = (
            np.column_stack([np.abs(joints), *np.linalg.norm(rate.reshape(-1, 2, 3), axis=2).T])
            for joints, rate in ((motion.dq, of.twist), (motion.ddq, of.acceleration))
        )
        return self._placed(time, q, p, R, (rates[chosen], changes[chosen]))

    def _placed(
        self, time: Array, q: Array, position: Array, rotation: Array, speeds: tuple[Array, Array] | None = None
    ) -> _Poses:
        """Bodies of the cell, and how far apart the balls around their shapes are."""
        count, cell = len(time), self._cell
        rates, changes = speeds or (np.zeros((count, q.shape[1] + 2)),) * 2
        arms = [body_poses(robot, q[:, at]) for robot, at in zip(cell.robots, cell.joint_slices.values(), strict=True)]
        one, nowhere = np.broadcast_to(np.eye(3), (count, 1, 3, 3)), np.zeros((count, 1, 3))
        R = np.concatenate([*(arm[0] for arm in arms), rotation[:, None], one], axis=1)
        p = np.concatenate([*(arm[1] for arm in arms), position[:, None], nowhere], axis=1)
        centers = np.einsum("ksij,sj->ksi", R[:, self._bodies], self._centers) + p[:, self._bodies]
        a, b = self._pairs.T
        apart = np.linalg.norm(centers[:, a] - centers[:, b], axis=2) - self._radii[a] - self._radii[b]
        seen = np.zeros(apart.shape, dtype=bool)
        return _Poses(time, R, p, rates, changes, apart, seen)

    def _distance(self, poses: _Poses, k: int, pair: int) -> float:
        a, b = self._pairs[pair]
        self._result.clear()
        transforms = []
        for shape, body in ((self._shapes[each], self._bodies[each]) for each in (a, b)):
            R, p = poses.R[k, body], poses.p[k, body]
            transforms.append(self._coal.Transform3s(R @ shape.pose.R, R @ shape.pose.p + p))
        return float(self._compute[pair](*transforms, self._request, self._result))

    def _measure(self, poses: _Poses, k: int, pair: int) -> float:
        if not poses.exact[k, pair]:
            poses.bounds[k, pair] = self._distance(poses, k, pair)
            poses.exact[k, pair] = True
        return float(poses.bounds[k, pair])

    def _look(self, poses: _Poses, progress: Progress = lambda _done, _total: None) -> Array:
        """The least distance at each pose, Shape (K,): the nearest balls first, until none can be nearer."""
        least = np.full(len(poses.time), np.inf)
        for k, order in enumerate(np.argsort(poses.bounds, axis=1)):
            progress(k, len(least))
            for pair in order.tolist():
                if poses.bounds[k, pair] >= least[k]:
                    break
                least[k] = min(least[k], self._measure(poses, k, pair))
        return least

    def _to_look_between(self, poses: _Poses, q: Array) -> NDArray[np.intp]:
        """Poses after which a pair may come nearer than any has: it has no more way than between the two poses."""
        if not self._pairs.size:
            return np.empty(0, dtype=np.intp)
        step = np.diff(poses.time)[:, None]
        rates, changes = (np.maximum(of[:-1], of[1:]) for of in (poses.rates, poses.changes))
        way = (step * (rates + step / 2 * changes)) @ self._arms_length(q).T
        least = float(np.min(poses.bounds))
        enough = least - max(RESOLUTION, SHARE * least)
        for k, pair in np.argwhere((poses.bounds[:-1] + poses.bounds[1:] - way) / 2 < enough).tolist():
            self._measure(poses, k, pair)
            self._measure(poses, k + 1, pair)
        return np.flatnonzero(np.any((poses.bounds[:-1] + poses.bounds[1:] - way) / 2 < enough, axis=1))

    def _arms_length(self, q: Array) -> Array:
        """How far a point of a pair moves against the other at most for each joint's and the object's, (P, m + 2)."""
        cell, slices = self._cell, [*self._cell.joint_slices.values()]
        reach = np.zeros((len(self._shapes), q.shape[1] + 2))
        for row, shape in zip(reach, self._shapes, strict=True):
            if shape.arm == len(cell.robots):
                row[-2:] = 1.0, np.linalg.norm(shape.center) + shape.radius
            elif shape.arm < len(cell.robots):
                joints = slices[shape.arm]
                row[joints][: shape.body] = _reaches(
                    cell.robots[shape.arm], shape, np.max(np.abs(q[:, joints]), axis=0)
                )
        a, b = self._pairs.T
        both = reach[a] + reach[b]
        same = np.array([self._shapes[one].arm == self._shapes[other].arm for one, other in self._pairs])
        # joints that carry both bodies of one arm do not move them against each other
        both[same] = np.where((reach[a] > 0) & (reach[b] > 0), 0.0, both)[same]
        return np.asarray(both)


def _reaches(robot: Robot, shape: Shape, most: Array) -> Array:
    """The largest distance of a shape's points from each joint that moves it, 1 for prismatic ones, Shape (body,)."""
    reach = float(np.linalg.norm(shape.center - robot.points[shape.body - 1])) + shape.radius
    found = np.empty(shape.body)
    for joint in range(shape.body - 1, -1, -1):
        found[joint] = reach if robot.turns[joint] else 1.0
        reach += 0.0 if robot.turns[joint] else float(most[joint])
        reach += float(np.linalg.norm(robot.points[joint] - robot.points[joint - 1])) if joint else 0.0
    return found


def _are_neighbours(robot: Robot, low: int, high: int) -> bool:
    """Whether one joint is between two bodies, or two whose axes meet."""
    if high != low + 2:
        return high == low + 1
    (u, v), between = robot.axes[low : low + 2], robot.points[low + 1] - robot.points[low]
    across = np.cross(u, v)
    size = float(np.linalg.norm(across))
    apart = abs(across @ between) / size if size > PARALLEL else np.inf
    return bool(np.all(robot.turns[low : low + 2])) and apart < MEETING


def coal_module() -> Any:
    """The library coal.

    Raises:
        InputError: If it is not installed.
    """
    require_extra("collisions", "collision", "coal")
    import coal  # noqa: PLC0415 (the extra 'collision')

    return coal


def _link_shapes(robot: Robot, arm: int, folder: Path | None) -> list[Shape]:
    """Shapes of an arm's links: of each its <collision>, else its <visual>; meshes as their convex hulls.

    Its URDF is relative to a folder.
    """
    if folder is None:
        rule = "it is not known where its URDF is: read its cell file, mrts.load_cell(path)."
        raise InputError(f"robot '{robot.name}'", rule)
    path, found = urdf_of(robot, folder), list[Shape]()
    with reading_meshes(path):
        source = robot.source
        model, bodies, base = posed_urdf(path, source.base_link, robot.joints, robot.held, visuals=False)
        for link, body in bodies.items():
            of_link = model.link_map[link]
            T_base_link = model.get_transform(link, base)
            for part in of_link.collisions or of_link.visuals:
                T = T_base_link if part.origin is None else T_base_link @ part.origin
                geometry = _link_geometry(path, part.geometry)
                if geometry is not None:
                    pose = RigidTransform(T[:3, :3], T[:3, 3])
                    found.append(_shape(f"{robot.name}/{link}", arm, body, geometry, pose))
    return found


def _link_geometry(path: Path, given: Any) -> Any:
    coal = coal_module()
    if given.box is not None:
        return coal.Box(*map(float, given.box.size))
    if given.sphere is not None:
        return coal.Sphere(float(given.sphere.radius))
    if given.cylinder is not None:
        return coal.Cylinder(float(given.cylinder.radius), float(given.cylinder.length))
    if given.mesh is None:
        return None
    import trimesh  # noqa: PLC0415 (half a second, for arms that have meshes)

    mesh: Any = trimesh.load(mesh_file(path, given.mesh.filename), force="mesh", skip_materials=True)
    scale = 1.0 if given.mesh.scale is None else given.mesh.scale
    return _hull(np.asarray(mesh.vertices) * scale) if len(mesh.vertices) else None


def _record_shape(name: str, arm: int, cell: Cell, record: BodyShape, *, hollow: bool = False) -> Shape:
    """The shape of the object or of an obstacle; a mesh as its convex hull, or "hollow" as its triangles."""
    coal = coal_module()
    if record.box is not None:
        geometry = coal.Box(*record.box)
    elif record.cylinder is not None:
        geometry = coal.Cylinder(record.cylinder.radius, record.cylinder.length)
    else:
        vertices, triangles = mesh_surface(record, cell.surfaces)
        geometry = _surface(vertices, triangles) if hollow else _hull(vertices)
    return _shape(name, arm, 0, geometry, record.pose.transform)


def _shape(name: str, arm: int, body: int, geometry: Any, pose: RigidTransform) -> Shape:
    geometry.computeLocalAABB()
    return Shape(name, arm, body, geometry, pose, pose.R @ geometry.aabb_center + pose.p, float(geometry.aabb_radius))


def _hull(points: Array) -> Any:
    from scipy.spatial import QhullError  # noqa: PLC0415 (only for meshes)
    from trimesh.convex import convex_hull  # noqa: PLC0415

    coal = coal_module()
    try:
        hull = convex_hull(points)
    except QhullError:  # flat: the box around it
        low, high = np.min(points, axis=0), np.max(points, axis=0)
        corners = np.stack(np.meshgrid(*np.stack([low, np.maximum(high, low + FLAT)], axis=1)), axis=-1)
        hull = convex_hull(corners.reshape(-1, 3))
    return coal.Convex(*_coal_lists(hull.vertices, hull.faces))


def _surface(vertices: Array, triangles: NDArray[np.int64]) -> Any:
    model = coal_module().BVHModelOBBRSS()
    model.beginModel(len(triangles), len(vertices))
    model.addSubModel(*_coal_lists(vertices, triangles))
    model.endModel()
    return model


def _coal_lists(vertices: Array, triangles: NDArray[Any]) -> tuple[Any, Any]:
    coal = coal_module()
    points, corners = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for vertex in np.asarray(vertices, dtype=np.float64):
        points.append(vertex)
    for triangle in triangles.tolist():
        corners.append(coal.Triangle(*triangle))
    return points, corners
