"""What a run leaves."""

from __future__ import annotations

import base64
import html
from pathlib import Path
from typing import Any, Dict, List, Optional

from . import _perifrac
from ._fields import Array, Fields
from ._folder import Folder
from ._history import History
from .errors import StateError


class Run:
    """A run that has ended, at its end or before."""

    def __init__(
        self,
        fields: Fields,
        history: History,
        summary: Optional[Dict[str, Any]],
        folder: Optional[Path],
        stopped: Optional[str],
        warnings: List[str],
        positions: Optional[Array],
        keep: Optional[Folder],
    ) -> None:
        #: Fields of the last state.
        self.fields = fields
        #: History up to it.
        self.history = history
        #: What ``perifrac run --json`` prints; nothing if the run failed or was interrupted.
        self.summary = summary
        #: Folder of its files; nothing if it wrote none.
        self.folder = folder
        #: Why it was stopped before its end, if it was.
        self.stopped = stopped
        #: Doubts that arose.
        self.warnings = warnings
        #: Coordinates of the points, m. Shape ``(n, dimension)``.
        self.positions = positions
        self._keep = keep

    @property
    def time(self) -> float:
        """Time of the last state, s."""
        return self.fields.time

    @property
    def errors(self) -> Dict[str, Dict[str, float]]:
        """Errors per field at the end, where the scene names an exact solution."""
        return {} if self.summary is None else self.summary["errors"]

    @property
    def steps(self) -> int:
        """Accepted steps."""
        return max(self.history.rows - 1, 0) if self.summary is None else self.summary["steps"]

    def report(self) -> Path:
        """Puts all that the run left on one page; gives its file."""
        if self.folder is None:
            raise StateError("the run wrote no files; give Simulation(..., out=FOLDER), or leave `out` away")
        return _perifrac.report(self.folder)

    def to_pyvista(self, cells: bool = True) -> Any:
        """The last fields as a ``pyvista`` grid; see :meth:`Fields.to_pyvista`."""
        return self.fields.to_pyvista(cells)

    def picture(self, name: Optional[str] = None, width: int = 560) -> bytes:
        """A picture of a field as PNG; see :meth:`Fields.picture`."""
        return self.fields.picture(name, width)

    def __repr__(self) -> str:
        why = f", stopped: {self.stopped}" if self.stopped else ""
        return f"<perifrac.Run to t = {self.time:g} s in {self.steps} steps{why}>"

    def _repr_html_(self) -> str:
        lines = {"time": f"{self.time:g} s", "steps": str(self.steps)}
        if self.stopped:
            lines["stopped"] = self.stopped
        if self.summary is not None:
            lines["scheme"] = self.summary["scheme"]
            lines["solver"] = self.summary["solver"] or "none"
            lines["wall time"] = f"{self.summary['wall_s']:.2f} s"
        for name, error in self.errors.items():
            lines[f"error of {name}"] = f"{error['l2']:.2e} of its range"
        lines.update({f"warning {number}": text for number, text in enumerate(self.warnings, 1)})
        rows = "".join(f"<tr><th>{html.escape(a)}</th><td>{html.escape(b)}</td></tr>" for a, b in lines.items())
        picture = base64.b64encode(self.picture()).decode() if self.fields else ""
        shown = f'<img alt="{self.fields.shown()}" src="data:image/png;base64,{picture}">' if picture else ""
        return f"<div><table>{rows}</table>{shown}</div>"
