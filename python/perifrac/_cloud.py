"""Points of the program."""

from __future__ import annotations

from typing import Any, List, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from .errors import CloudError

Array = npt.NDArray[np.float64]


class Cloud:
    """Points with their volumes, in place of those that ``[geometry]`` makes.

    ``position`` has shape ``(n, 2)`` or ``(n, 3)``, m; ``volume`` is that of the cell of each point, m³, or its area in
    the plane, m². ``permeability`` (m²) and ``material`` (names in the scene) are one for each point, if they are given.
    Arrays of 64-bit floats are taken as they are.
    """

    def __init__(
        self,
        position: npt.ArrayLike,
        volume: npt.ArrayLike,
        *,
        permeability: Optional[npt.ArrayLike] = None,
        material: Optional[Sequence[str]] = None,
    ) -> None:
        self.position = _numbers("position", position)
        if self.position.ndim != 2 or self.position.shape[1] not in (2, 3):
            raise CloudError(f"position has shape {self.position.shape}; (n, 2) or (n, 3) is needed")
        points = len(self.position)
        self.volume = _numbers("volume", np.broadcast_to(np.asarray(volume, dtype=np.float64), (points,)))
        self.permeability = None if permeability is None else _numbers("permeability", permeability)
        self.material: Optional[List[str]] = None if material is None else [str(name) for name in material]
        if self.permeability is not None and self.permeability.ndim != 1:
            raise CloudError(f"permeability has shape {self.permeability.shape}; ({points},) is needed")

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        return f"<perifrac.Cloud of {len(self)} points in {self.position.shape[1]}-D>"

    def parts(self) -> Tuple[Array, Array, Optional[Array], Optional[List[str]]]:
        """What the compiled part takes."""
        return self.position, self.volume, self.permeability, self.material


def _numbers(what: str, values: Any) -> Array:
    try:
        return np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise CloudError(f"{what}: {error}") from error
