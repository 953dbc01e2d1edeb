"""Finite elements of a disc in plane stress, condensed to its flanks and bearings (docs/theory.md, Eqs. 83, 84)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import skfem
from scipy.sparse import csc_array, hstack
from scipy.sparse.linalg import splu
from skfem.models.elasticity import linear_elasticity
from threadpoolctl import threadpool_limits

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.contact.bodies.elastic_disc._mesh import triangulated, xy

_ABREAST = 32  # loads solved at once; more need more memory and no less time


def condensed(
    flank: ComplexArray,
    normal: ComplexArray,
    openings: Sequence[ComplexArray],
    bearings: Sequence[int],
    carriers: Sequence[int],
    depth: FloatArray,
    poisson_ratio: float,
    largest: float,
) -> tuple[FloatArray, FloatArray]:
    """Compliance of a disc of unit width and unit modulus, and that of each flank point at its ``depth``.

    Parameters
    ----------
    flank, normal : points of the tooth curve and its outward normals, shape (points,) [mm]
    openings : points of each opening [mm]
    bearings : which openings hold a bearing
    carriers : which openings keep the disc from turning, by the forces in them; none: the edge of the bearings
    depth : below each point of the flank, where its own recession is read [mm]
    poisson_ratio : ν
    largest : size of a triangle [mm]

    Returns
    -------
    compliance : shape (forces, forces), of forces inwards on each flank point, then both components on each bearing.
        Displacements count from the mean motion of the bearings and the mean turn of the carriers [1]
    own : compliance of each flank point under its own force, read at ``depth`` [1]
    """
    rings = [flank, *openings]
    basis = disc_basis(rings, largest)
    stiffness = plane_stress(basis, poisson_ratio)
    ends = np.cumsum([len(ring) for ring in rings])
    mean = [_mean_displacement(basis, int(begin), int(end)) for begin, end in pairwise(ends)]
    rigid = _rigid_motions(basis)
    if carriers:
        turn = _turn_of_several([mean[i] for i in carriers], rigid)
    else:
        turn = _turn_of_edge(basis, int(ends[bearings[0]]), int(ends[bearings[0] + 1]))
    frame = np.concatenate([np.mean([mean[i] for i in bearings], axis=0), turn[:, np.newaxis]], axis=1)
    own_forces = [_inwards(basis, normal), *(csc_array(mean[i]) for i in bearings)]
    forces = hstack([*own_forces, csc_array(frame)]).tocsc()
    # Each force with its reactions at bearings and carriers; equally, displacements in the frame of these.
    read = _below(basis, flank - depth * normal, normal)
    reaction, of_read = (-np.linalg.solve(rigid.T @ frame, (one.T @ rigid).T) for one in (hstack(own_forces), read))
    raw, straight = _displacements(stiffness, _three_fixed(basis), forces, (forces, read))
    count = reaction.shape[1]
    rows = raw[:count] + reaction.T @ raw[count:]
    compliance = rows[:, :count] + rows[:, count:] @ reaction
    below = straight + of_read.T @ raw[count:]
    own = np.diag(below[:, : len(flank)]) + np.einsum("ij,ji->i", below[:, count:], reaction[:, : len(flank)])
    return compliance, own


def disc_basis(rings: Sequence[ComplexArray], largest: float = 5.0) -> Any:
    """Quadratic triangles of the area between ``rings``, no larger than ``largest`` [mm]."""
    points, triangles = triangulated(rings, largest)
    mesh = skfem.MeshTri(points.T.copy(), triangles.T.copy())
    return skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTriP2()))


def plane_stress(basis: Any, poisson_ratio: float) -> Any:
    """Stiffness matrix of unit modulus and width in plane stress: λ is replaced by E ν/(1 − ν²)."""
    first, second = poisson_ratio / (1.0 - poisson_ratio**2), 0.5 / (1.0 + poisson_ratio)
    return linear_elasticity(first, second).assemble(basis).tocsc()


def _inwards(basis: Any, normal: ComplexArray) -> Any:
    """Unit forces inwards on the first nodes, shape (unknowns, forces)."""
    node = np.arange(len(normal))
    unknown = basis.nodal_dofs[:, : len(normal)]
    parts = (np.concatenate([-normal.real, -normal.imag]), (unknown.ravel(), np.tile(node, 2)))
    return csc_array(parts, shape=(basis.N, len(normal)))


def _below(basis: Any, place: ComplexArray, normal: ComplexArray) -> Any:
    """Displacement against ``normal`` at places inside, as a functional, shape (unknowns, places)."""
    cell = basis.mesh.element_finder()(place.real.copy(), place.imag.copy())
    local = basis.mapping.invF(xy(place).T[:, :, np.newaxis], tind=cell)
    weight = np.empty((basis.Nbfun, len(place)))
    for i in range(basis.Nbfun):
        shape = np.asarray(basis.elem.gbasis(basis.mapping, local, i, tind=cell)[0])[..., 0]
        weight[i] = -shape[0] * normal.real - shape[1] * normal.imag
    unknown = basis.element_dofs[:, cell]
    at = np.broadcast_to(np.arange(len(place)), unknown.shape)
    return csc_array((weight.ravel(), (unknown.ravel(), at.ravel())), shape=(basis.N, len(place)))


def _edge(basis: Any, begin: int, end: int) -> Any:
    """Basis on the edge with these nodes."""
    edges = basis.mesh.boundary_facets()
    nodes = basis.mesh.facets[:, edges]
    return skfem.FacetBasis(basis.mesh, basis.elem, facets=edges[np.all((nodes >= begin) & (nodes < end), axis=0)])


def _mean_displacement(basis: Any, begin: int, end: int) -> FloatArray:
    """Mean displacement of the edge with these nodes, equally a uniform unit load there, shape (unknowns, 2)."""
    along = _edge(basis, begin, end)
    total = [skfem.LinearForm(lambda v, _, i=i: v[i]).assemble(along) for i in range(2)]
    return np.stack(total, axis=1) / float(np.sum(along.dx))


def _turn_of_edge(basis: Any, begin: int, end: int) -> FloatArray:
    """Mean turn about the origin of the edge with these nodes, equally a unit moment there, shape (unknowns,)."""
    along = _edge(basis, begin, end)
    moment = skfem.LinearForm(lambda v, w: w.x[0] * v[1] - w.x[1] * v[0]).assemble(along)
    reach = skfem.Functional(lambda w: w.x[0] ** 2 + w.x[1] ** 2).assemble(along)
    return np.asarray(moment / reach)


def _turn_of_several(means: list[FloatArray], rigid: FloatArray) -> FloatArray:
    """Turn about the origin that fits the mean displacements of several edges best, equally a unit moment by uniform
    loads there, shape (unknowns,).
    """
    swing = [one.T @ rigid[:, 2] for one in means]
    moment = sum(one @ each for one, each in zip(means, swing, strict=True))
    return np.asarray(moment / sum(float(each @ each) for each in swing))


def _rigid_motions(basis: Any) -> FloatArray:
    """Displacements of two unit shifts and a unit turn about the origin, shape (unknowns, 3)."""
    x, y = basis.doflocs
    across = np.zeros(basis.N, dtype=bool)
    across[basis.nodal_dofs[1]] = across[basis.facet_dofs[1]] = True
    return np.stack([~across, across, np.where(across, x, -y)], axis=1).astype(np.float64)


def _three_fixed(basis: Any) -> IntArray:
    """Unknowns that keep the disc in place: the node furthest to the right, and the furthest to the left across."""
    x = basis.mesh.p[0]
    right, left = int(np.argmax(x)), int(np.argmin(x))
    return np.array([*basis.nodal_dofs[:, right], basis.nodal_dofs[1, left]])


def _displacements(stiffness: Any, fixed: IntArray, forces: Any, reads: Sequence[Any]) -> list[FloatArray]:
    """Each of ``reads`` of the displacements under ``forces``, shape (reads, forces), with three unknowns ``fixed``.

    All are sparse, shape (unknowns, forces or reads). The displacements of all unknowns are never held at once.
    """
    free = np.setdiff1d(np.arange(stiffness.shape[0]), fixed)
    found = [np.empty((one.shape[1], forces.shape[1])) for one in reads]
    transposed = [one.T.tocsr() for one in reads]
    # Its short dense products lose a factor of ten to threads that wait for each other on a busy machine.
    with threadpool_limits(1, "blas"):
        # A symmetric positive matrix: its own order of unknowns without exchange of rows halves the time.
        factors = splu(
            stiffness[free][:, free], permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
        loads = forces[free]
        for at in range(0, forces.shape[1], _ABREAST):
            cut = slice(at, at + _ABREAST)
            some = loads[:, cut].toarray()
            moved = np.zeros((stiffness.shape[0], some.shape[1]))
            moved[free] = factors.solve(some)
            for values, one in zip(found, transposed, strict=True):
                values[:, cut] = one @ moved
    return found
