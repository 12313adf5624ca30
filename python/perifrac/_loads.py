"""Sources and forces that are functions in Python."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, List, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from .errors import LoadError

#: What a load may return: one value for all points, or one for each.
Rates = Union[float, npt.ArrayLike]


@dataclass(frozen=True)
class Points:
    """The points of a run, as a load sees them. Both arrays are read-only."""

    #: Coordinates, m. Shape ``(n, dimension)``.
    position: npt.NDArray[np.float64]
    #: Volume of the cell of each point, m³; area in the plane, m². Shape ``(n,)``.
    volume: npt.NDArray[np.float64]


@dataclass(frozen=True)
class Load:
    """A source or a force; made by :func:`source` and :func:`force`."""

    function: Callable[[float, Points], Rates]
    on_solid: bool
    name: str
    breakpoints: Sequence[float]
    constant: bool

    def parts(self) -> Tuple[Any, bool, str, List[float], bool]:
        """What the compiled part takes."""
        breakpoints = [float(time) for time in self.breakpoints]
        return self.function, self.on_solid, self.name, breakpoints, self.constant


def source(
    function: Callable[[float, Points], Rates],
    *,
    name: Optional[str] = None,
    breakpoints: Sequence[float] = (),
    constant: bool = False,
) -> Load:
    """A source of fluid: ``function(time, points)`` gives the volume per second that comes in at each point, m³/s
    (m²/s in the plane).

    It is asked for times within a step, some of them twice, and must give the same at the same time. Steps end at
    ``breakpoints`` (s), where the rate jumps or bends. What is ``constant`` is asked for once.
    """
    return Load(function, False, name or _name(function, "source"), tuple(breakpoints), constant)


def force(
    function: Callable[[float, Points], Rates],
    *,
    name: Optional[str] = None,
    breakpoints: Sequence[float] = (),
    constant: bool = False,
) -> Load:
    """A force on the rock: ``function(time, points)`` gives the force on each point, N (N/m in the plane), of shape
    ``(n, dimension)``. The rest is as in :func:`source`.
    """
    return Load(function, True, name or _name(function, "force"), tuple(breakpoints), constant)


def _name(function: Any, fallback: str) -> str:
    name = getattr(function, "__name__", fallback)
    return fallback if name == "<lambda>" else name


def as_rates(
    found: Any, shape: Sequence[int], on_solid: bool, name: str, time: float
) -> npt.NDArray[np.float64]:
    """Values of a load as one array, checked."""
    wanted = tuple(shape) if on_solid else (shape[0],)
    try:
        rates = np.broadcast_to(np.asarray(found, dtype=np.float64), wanted)
    except (TypeError, ValueError) as error:
        raise LoadError(
            f'the load "{name}" gave {_told(found)} at t = {time:g} s; values of shape {wanted} are needed'
        ) from error
    if not np.isfinite(rates).all():
        point = int(np.flatnonzero(~np.isfinite(rates.reshape(shape[0], -1)).all(axis=1))[0])
        raise LoadError(f'the load "{name}" is not finite at point {point} at t = {time:g} s')
    return np.ascontiguousarray(rates)


def _told(found: Any) -> str:
    shape = getattr(found, "shape", None)
    return f"an array of shape {shape}" if shape is not None else repr(found)
