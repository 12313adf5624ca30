"""The history of a run: one row for its start and one for each step."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from ._optional import optional

_UNIT = re.compile(r"(.+)_(s|m|m2|m3|m3_per_s|Pa|N|J)")


class History(Mapping[str, npt.NDArray[np.float64]]):
    """Columns of ``history.csv`` as arrays, under their headings (``"pressure_max_Pa"``) or without the unit
    (``"pressure_max"``); a dot is as good as an underscore, and the pressure of a crack is found as ``"pressure.NAME"``.

    Arrays are read-only, and an array that was taken stays as it is while the run goes on.
    """

    def __init__(self, columns: Sequence[str] = ()) -> None:
        self._columns: List[str] = list(columns)
        self._rows = np.empty((16, len(self._columns)))
        self._count = 0

    def _begin(self, columns: Sequence[str]) -> None:
        if not self._columns:
            self.__init__(columns)  # type: ignore[misc]

    def _append(self, row: Sequence[float]) -> None:
        if self._count == len(self._rows):
            # Arrays that were taken keep the old rows.
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        self._rows[self._count] = row
        self._count += 1

    def _read(self, path: Path) -> None:
        """Takes in the rows of a run that is gone on with."""
        with open(path, newline="", encoding="utf-8") as file:
            lines = csv.reader(file)
            self._begin(next(lines))
            for line in lines:
                self._append([float(value) for value in line])

    @property
    def columns(self) -> List[str]:
        """The headings."""
        return list(self._columns)

    def heading(self, name: str) -> str:
        """The heading that a name stands for.

        Raises :class:`KeyError` with the headings that there are.
        """
        plain = name.replace(".", "_")
        for wanted in (plain, f"crack_{plain}"):
            for column in self._columns:
                unit = _UNIT.fullmatch(column)
                if column == wanted or (unit and unit.group(1) == wanted):
                    return column
        raise KeyError(f"{name!r} is no column of this history; it has {', '.join(self._columns)}")

    def __getitem__(self, name: str) -> npt.NDArray[np.float64]:
        column = self._rows[: self._count, self._columns.index(self.heading(name))]
        column.flags.writeable = False
        return column

    def __contains__(self, name: object) -> bool:
        try:
            self.heading(str(name))
        except KeyError:
            return False
        return True

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self._count

    def to_dict(self) -> Dict[str, npt.NDArray[np.float64]]:
        """All columns."""
        return {name: self[name] for name in self._columns}

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` with the headings as columns."""
        pandas = optional("pandas", "History.to_pandas()")
        return pandas.DataFrame(self._rows[: self._count].copy(), columns=self._columns)

    def plot(self, x: str, y: str, *more: str, ax: Any = None, **style: Any) -> Any:
        """Draws columns over another one with matplotlib; gives the axes."""
        pyplot = optional("matplotlib.pyplot", "History.plot()", "matplotlib")
        ax = pyplot.subplots()[1] if ax is None else ax
        names = (y, *more)
        for name in names:
            ax.plot(self[x], self[name], **{"label": name, **style})
        ax.set_xlabel(_label(self.heading(x)))
        ax.set_ylabel(_label(self.heading(y)) if len(names) == 1 else "")
        if len(names) > 1:
            ax.legend()
        return ax

    def __repr__(self) -> str:
        return f"<perifrac.History of {self._count} rows: {', '.join(self._columns)}>"


def _label(column: str) -> str:
    unit = _UNIT.fullmatch(column)
    if not unit:
        return column.replace("_", " ")
    return f"{unit.group(1).replace('_', ' ')} [{unit.group(2).replace('_per_', '/')}]"
