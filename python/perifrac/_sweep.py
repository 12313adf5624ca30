"""Many runs of one scene."""

from __future__ import annotations

import html
import itertools
import os
import threading
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence

from ._loads import Load
from ._optional import optional
from ._run import Run
from ._scene import Scene, SceneLike, as_scene
from ._simulation import Simulation
from .errors import Interrupted, PerifracError

#: Seconds after which a key that was pressed is heard.
_PATIENCE = 0.05


class Table(List[Dict[str, Any]]):
    """One dict for each run, in the order of the values."""

    @property
    def columns(self) -> List[str]:
        """All keys, in the order in which they first come."""
        return list(dict.fromkeys(key for row in self for key in row))

    def column(self, name: str) -> List[Any]:
        """One value for each run; ``None`` where a run has none."""
        if name not in self.columns:
            raise KeyError(f"{name!r} is no column of this table; it has {', '.join(self.columns)}")
        return [row.get(name) for row in self]

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame``."""
        pandas = optional("pandas", "Table.to_pandas()")
        return pandas.DataFrame(list(self), columns=self.columns)

    def _repr_html_(self) -> str:
        def cell(value: Any) -> str:
            text = "" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)
            return f"<td>{html.escape(text)}</td>"

        head = "".join(f"<th>{html.escape(name)}</th>" for name in self.columns)
        rows = ("<tr>" + "".join(cell(row.get(name)) for name in self.columns) + "</tr>" for row in self)
        return f"<table><tr>{head}</tr>{''.join(rows)}</table>"


def sweep(
    scene: SceneLike,
    values: Mapping[str, Sequence[Any]],
    *,
    jobs: int = 1,
    threads: Optional[int] = None,
    measure: Optional[Callable[[Run], Mapping[str, Any]]] = None,
    loads: Sequence[Load] = (),
    on_error: str = "keep",
) -> Table:
    """Runs a scene for all combinations of values of some keys, ``jobs`` runs at a time.

    Each row has the values, ``status``, ``steps``, ``rejected``, ``wall_s``, ``t_end``, the relative errors of fields
    that have an exact solution (``error.pressure``), ``pressure_min``, ``pressure_max``, ``displacement_max``, rates of
    outflow and what broke, where there are such, and what ``measure(run)`` adds. A run that fails has its message as
    ``error`` in the table; ``on_error="raise"`` raises it. No files are written. ``threads`` is that of each run: the
    processors shared out by default.
    """
    base = as_scene(scene)
    grid = [dict(zip(values, chosen)) for chosen in itertools.product(*values.values())]
    share = threads or max(1, (os.cpu_count() or 1) // max(1, jobs))
    desk = _Desk(base, share, measure, loads, on_error)
    with ThreadPoolExecutor(max(1, jobs)) as pool:
        futures = [pool.submit(desk.row, changes) for changes in grid]
        try:
            _await(futures)
        except BaseException:
            desk.stop()
            pool.shutdown(cancel_futures=True)
            raise
    return Table(future.result() for future in futures)


def _await(futures: Sequence["Future[Dict[str, Any]]"]) -> None:
    left = set(futures)
    while left:
        # A short wait, so that Ctrl-C is heard.
        done, left = wait(left, timeout=_PATIENCE, return_when=FIRST_COMPLETED)
        for future in done:
            future.result()


class _Desk:
    """What the runs of a sweep share."""

    def __init__(
        self,
        scene: Scene,
        threads: int,
        measure: Optional[Callable[[Run], Mapping[str, Any]]],
        loads: Sequence[Load],
        on_error: str,
    ) -> None:
        self.scene, self.threads, self.measure, self.loads = scene, threads, measure, loads
        self.raises = on_error == "raise"
        self.stopped = False
        self.running: List[Simulation] = []
        self.lock = threading.Lock()

    def row(self, changes: Dict[str, Any]) -> Dict[str, Any]:
        """The row of one run."""
        row = dict(changes)
        try:
            run = self.carry_out(changes)
        except PerifracError as error:
            if self.raises or self.stopped:
                raise
            return {**row, "status": type(error).__name__, "error": str(error)}
        row.update(figures(run))
        if self.measure is not None:
            row.update(self.measure(run))
        return row

    def carry_out(self, changes: Dict[str, Any]) -> Run:
        simulation = Simulation(self.scene.changed(changes), threads=self.threads, out=False, loads=self.loads)
        with self.lock:
            if self.stopped:
                raise Interrupted("the sweep was stopped")
            self.running.append(simulation)
        try:
            return simulation.run()
        finally:
            with self.lock:
                self.running.remove(simulation)

    def stop(self) -> None:
        """Stops what runs."""
        with self.lock:
            self.stopped = True
            for simulation in self.running:
                simulation.interrupt()


def figures(run: Run) -> Dict[str, Any]:
    """The figures of a run that fit into a row."""
    summary = run.summary or {}
    row: Dict[str, Any] = {"status": "done"}
    row.update({name: summary.get(name) for name in ("steps", "rejected", "wall_s", "t_end")})
    row.update({f"error.{name}": error["l2"] for name, error in summary.get("errors", {}).items()})
    if "pressure_range" in summary:
        row["pressure_min"], row["pressure_max"] = summary["pressure_range"]
    if "displacement_max" in summary:
        row["displacement_max"] = summary["displacement_max"]
    row.update({f"outflow.{side}": rate for side, rate in summary.get("outflow", {}).items()})
    results = summary.get("results") or {}
    row.update({name: value for name, value in results.items() if isinstance(value, (int, float))})
    return row
