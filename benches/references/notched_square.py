"""A sharp crack in the notched square, by finite elements: what `notched-tension` and `notched-shear` are compared with.

    pip install gmsh scikit-fem
    python benches/references/notched_square.py tension
    python benches/references/notched_square.py shear 0.03 16 1.5

Plane strain, quadratic triangles on linear geometry, refined at the tip. Each line is an equilibrium with the crack
at its tip: the energy release rate G by a domain integral, K_I and K_II by the jumps of the faces, scaled to that G; the
load at which G = G_c, and the one at which the largest hoop stress is critical. The crack grows towards that stress.
Arguments: `tension` or `shear`, growth a step (mm), steps, size of the elements at the tip (µm).
"""

import sys

import gmsh
import numpy as np
from skfem import Basis, BilinearForm, ElementTriP2, ElementVector, Functional, MeshTri, condense, solve
from skfem.helpers import ddot, div, sym_grad

YOUNG, POISSON, TOUGHNESS = 210e9, 0.3, 2700.0
LAMBDA = YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON)
MU = YOUNG / 2 / (1 + POISSON)
PLANE = YOUNG / (1 - POISSON**2)
EDGE = 1e-3
#: Displacement of the top for which all is computed, m.
UNIT = 1e-6


def mesh(crack, size):
    """Triangles round a crack: nodes, triangles, and the nodes of the upper and lower face next to the tip."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("square")
    geo = gmsh.model.geo
    chain = np.array(crack)
    along = np.diff(chain, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], 1)
    normals = np.vstack([across[:1], across[:-1] + across[1:]]) if len(chain) > 2 else across[:1]
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    # A wedge of 1e-4 of the edge: faces that coincide cannot be meshed.
    gap = 1e-4 * EDGE * np.linspace(1, 1 / len(chain), len(chain) - 1)[:, None]
    point = lambda at: geo.addPoint(*at, 0)
    lower = [point(p) for p in chain[:-1] - gap * normals]
    tip = point(chain[-1])
    upper = [point(p) for p in chain[:-1] + gap * normals]
    corners = [point(p) for p in [(0, 0), (EDGE, 0), (EDGE, EDGE), (0, EDGE)]]
    ring = corners + upper + [tip] + lower[::-1]
    lines = [geo.addLine(a, b) for a, b in zip(ring, ring[1:] + ring[:1])]
    geo.addPlaneSurface([geo.addCurveLoop(lines)])
    geo.synchronize()
    field = gmsh.model.mesh.field
    field.add("Distance", 1)
    field.setNumbers(1, "PointsList", [tip])
    field.add("Threshold", 2)
    for key, value in dict(InField=1, SizeMin=size, SizeMax=0.04 * EDGE, DistMin=10 * size, DistMax=0.4 * EDGE).items():
        field.setNumber(2, key, value)
    field.setAsBackgroundMesh(2)
    for option in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
        gmsh.option.setNumber("Mesh.MeshSize" + option, 0)
    gmsh.model.mesh.generate(2)
    tags, nodes, _ = gmsh.model.mesh.getNodes()
    number = {tag: i for i, tag in enumerate(tags)}
    of = lambda found: np.array([number[tag] for tag in found])
    triangles = of(gmsh.model.mesh.getElements(2)[2][0]).reshape(-1, 3)
    last = 4 + len(upper) - 1
    faces = [of(gmsh.model.mesh.getNodes(1, lines[k], True)[0]) for k in (last, last + 1)]
    gmsh.finalize()
    used = np.unique(triangles)
    back = -np.ones(len(nodes) // 3, int)
    back[used] = np.arange(len(used))
    return nodes.reshape(-1, 3)[used, :2], back[triangles], back[faces[0]], back[faces[1]]


def equilibrium(crack, top, size):
    """Force on the top (N/m), G (J/m²), K_I, K_II (Pa √m) and the direction of the last part of a crack."""
    nodes, triangles, upper, lower = mesh(crack, size)
    cloud = MeshTri(nodes.T.copy(), triangles.T.copy())
    basis = Basis(cloud, ElementVector(ElementTriP2()), intorder=4)
    stiffness = BilinearForm(
        lambda u, v, _: LAMBDA * div(u) * div(v) + 2 * MU * ddot(sym_grad(u), sym_grad(v))
    ).assemble(basis)
    bottom = basis.get_dofs(lambda x: np.isclose(x[1], 0))
    lid = basis.get_dofs(lambda x: np.isclose(x[1], EDGE))
    shift = np.zeros(basis.N)
    for axis, name in enumerate(["u^1", "u^2"]):
        shift[lid.all(name)] = top[axis]
    held = np.unique(np.concatenate([bottom.all(), lid.all()]))
    shift = solve(*condense(stiffness, x=shift, D=held))
    reaction = stiffness @ shift
    force = [reaction[lid.all(name)].sum() for name in ("u^1", "u^2")]
    tip, before = np.array(crack[-1]), np.array(crack[-2])
    length = np.linalg.norm(tip - before)
    along = (tip - before) / length
    normal = np.array([-along[1], along[0]])
    near, far = 5 * size, min(0.8 * length, 40 * size)

    def integrand(w):
        away = np.stack([w.x[0] - tip[0], w.x[1] - tip[1]])
        distance = np.sqrt((away**2).sum(0))
        inside = (distance > near) & (distance < far)
        slope = np.where(inside, -1 / (far - near), 0.0) * away / np.maximum(distance, 1e-30)
        gradient = w["u"].grad
        strain = 0.5 * (gradient + gradient.transpose(1, 0, 2, 3))
        stress = 2 * MU * strain + LAMBDA * (strain[0, 0] + strain[1, 1]) * np.eye(2)[:, :, None, None]
        energy = 0.5 * (stress * strain).sum((0, 1))
        advance = np.einsum("ijkl,j->ikl", gradient, along)
        return np.einsum("ijkl,ikl,jkl->kl", stress, advance, slope) - energy * np.einsum("jkl,j->kl", slope, along)

    released = Functional(integrand).assemble(basis, u=basis.interpolate(shift))
    behind = lambda found: (tip - cloud.p[:, found].T) @ along
    upper, lower = (found[np.argsort(behind(found))] for found in (upper, lower))
    distance = behind(upper)[1:]
    jump = (shift[basis.nodal_dofs[:, upper]] - shift[basis.nodal_dofs[:, lower]])[:, 1:]
    seen = (distance > 3 * size) & (distance < min(30 * size, 0.6 * length))
    factor = PLANE / 8 * np.sqrt(2 * np.pi / distance)
    modes = [np.polyfit(distance[seen], (factor * (way @ jump))[seen], 1)[1] for way in (normal, along)]
    scale = np.sqrt(released * PLANE) / np.hypot(*modes)
    return force, released, modes[0] * scale, modes[1] * scale, along


def main():
    way = sys.argv[1]
    growth, steps, size = (float(a) for a in sys.argv[2:5]) if len(sys.argv) > 4 else (0.02, 0, 4.0)
    top, axis = ((0, UNIT), 1) if way == "tension" else ((UNIT, 0), 0)
    crack = [(0, 0.5 * EDGE), (0.5 * EDGE, 0.5 * EDGE)]
    print("tip mm, stiffness kN/mm, K_I/K_II, turn °, G = G_c: µm, kN, hoop stress: µm, kN")
    for _ in range(int(steps) + 1):
        force, released, one, two, along = equilibrium(crack, top, 1e-6 * size)
        turn = 2 * np.arctan((one - np.hypot(one, np.sqrt(8) * two)) / (4 * two)) if two else 0.0
        hoop = np.cos(turn / 2) ** 2 * (one * np.cos(turn / 2) - 3 * two * np.sin(turn / 2))
        loads = [np.sqrt(TOUGHNESS / released), np.sqrt(TOUGHNESS * PLANE) / hoop]
        tip = np.array(crack[-1])
        row = [*(1e3 * tip), 1e-9 * force[axis] / UNIT, one / two, np.degrees(turn)]
        row += [value for load in loads for value in (load, 1e-6 * load * force[axis])]
        print(" ".join(f"{value:10.4f}" for value in row), flush=True)
        angle = np.arctan2(along[1], along[0]) + turn
        tip = tip + 1e-3 * growth * np.array([np.cos(angle), np.sin(angle)])
        if not (0.02 * EDGE < tip[1] < 0.98 * EDGE and tip[0] < 0.98 * EDGE):
            break
        crack.append(tuple(tip))


if __name__ == "__main__":
    main()
