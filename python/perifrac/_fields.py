"""Fields of a state."""

from __future__ import annotations

from typing import Any, Dict, Iterator, Mapping, Optional, Tuple

import numpy as np
import numpy.typing as npt

from ._optional import optional

Array = npt.NDArray[np.float64]


class Ground:
    """The points of a run."""

    def __init__(self, dimension: int, positions: Array, cells: Array) -> None:
        #: 2 or 3.
        self.dimension = dimension
        #: Coordinates, m. Shape ``(n, dimension)``.
        self.positions = positions
        #: Edges of the cell of each point, m. Shape ``(n, dimension)``.
        self.cells = cells


class Fields(Mapping[str, Array]):
    """Fields by their names, as the files of an output have them.

    Arrays are read-only and own their numbers: they stay as they are while the run goes on. Shapes are ``(n,)`` or
    ``(n, components)``; a stress has xx, yy, zz, xy, yz, xz.
    """

    def __init__(self, values: Dict[str, Array], units: Dict[str, str], ground: Optional[Ground], time: float) -> None:
        self._values = values
        self._ground = ground
        #: SI unit of each field.
        self.units = units
        #: Time of the state, s.
        self.time = time

    def __getitem__(self, name: str) -> Array:
        try:
            return self._values[name]
        except KeyError:
            raise KeyError(f"{name!r} is no field of this scene; it has {', '.join(self._values)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        told = (f"{name} [{self.units[name] or '1'}] {value.shape}" for name, value in self._values.items())
        return f"<perifrac.Fields at t = {self.time:g} s: {', '.join(told)}>"

    def to_pyvista(self, cells: bool = True) -> Any:
        """A ``pyvista`` grid with the fields: one cell for each point, or the points alone."""
        pyvista = optional("pyvista", "to_pyvista()")
        ground = self._here()
        if cells:
            corners, boxes = boxes_of(ground)
            kind = pyvista.CellType.QUAD if ground.dimension == 2 else pyvista.CellType.HEXAHEDRON
            grid = pyvista.UnstructuredGrid({kind: boxes}, corners)
            data = grid.cell_data
        else:
            grid = pyvista.PolyData(in_space(ground.positions))
            data = grid.point_data
        for name, value in self._values.items():
            padded = value.ndim == 2 and value.shape[1] == 2
            data[name] = in_space(value) if padded else value
        return grid

    def picture(self, name: Optional[str] = None, width: int = 560) -> bytes:
        """A picture of a field as PNG: the plane, or the middle layer of points in space, and of vectors the length."""
        from . import _perifrac

        name = self.shown() if name is None else name
        ground, values = self._here(), self[name]
        values = values if values.ndim == 1 else np.sqrt((values**2).sum(axis=1))
        layer = middle_layer(ground)
        return _perifrac.picture(
            np.ascontiguousarray(ground.positions[layer, :2]).ravel(),
            np.ascontiguousarray(ground.cells[layer, :2].max(axis=1)),
            np.ascontiguousarray(values[layer]),
            (name.replace("_", " "), self.units[name]),
            self.time,
            width,
        )

    def shown(self) -> str:
        """The field that says most: damage where there is any, else pressure or displacement."""
        if "damage" in self and self["damage"].max() > 0.0:
            return "damage"
        known = (name for name in ("pressure", "displacement", "volume") if name in self)
        return next(known)

    def _here(self) -> Ground:
        from .errors import StateError

        if self._ground is None:
            raise StateError("the run has no points yet; let it step first")
        return self._ground


def in_space(values: Array) -> Array:
    """Vectors of the plane as vectors in space."""
    if values.shape[1] == 3:
        return values
    return np.column_stack([values, np.zeros(len(values))])


def boxes_of(ground: Ground) -> Tuple[Array, npt.NDArray[np.int64]]:
    """Corners in space and, for each point, the numbers of the corners of its cell in the order of VTK; cells that
    touch share corners."""
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=np.float64)
    if ground.dimension == 3:
        below, above = (np.column_stack([signs, np.full(4, z)]) for z in (-1.0, 1.0))
        signs = np.vstack([below, above])
    corners = ground.positions[:, None, :] + 0.5 * signs[None, :, :] * ground.cells[:, None, :]
    flat = corners.reshape(-1, ground.dimension)
    grain = 1e-6 * ground.cells.min()
    _, first, number = np.unique(np.round(flat / grain).astype(np.int64), axis=0, return_index=True, return_inverse=True)
    return in_space(flat[first]), number.reshape(len(ground.positions), len(signs))


def middle_layer(ground: Ground) -> npt.NDArray[np.int64]:
    """All points of a plane; in space those of the layer nearest to the middle."""
    if ground.dimension == 2:
        return np.arange(len(ground.positions))
    height = ground.positions[:, 2]
    middle = 0.5 * (height.min() + height.max())
    near = np.flatnonzero(np.abs(height - middle) <= 0.5001 * ground.cells[:, 2])
    lowest = height[near].min()
    lower: npt.NDArray[np.int64] = near[height[near] < lowest + 0.25 * ground.cells[near, 2]]
    return lower
