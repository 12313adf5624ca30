"""Runs, whole or step by step."""

from __future__ import annotations

import json
import os
import warnings
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple, Union

from . import _perifrac
from ._fields import Array, Fields, Ground
from ._folder import Folder
from ._history import History
from ._loads import Load
from ._progress import Progress
from ._run import Run
from ._scene import Scene, SceneLike, as_scene
from .errors import CheckpointError, PerifracWarning, RunError, StateError, UsageError

_Path = Union[str, "os.PathLike[str]"]
_Numbers = Tuple[float, float, float, int, int, int, Optional[float]]


class Step:
    """An accepted step, at which the run waits."""

    def __init__(self, simulation: "Simulation", numbers: _Numbers) -> None:
        self._simulation = simulation
        self._fields: Optional[Fields] = None
        time, end, dt, steps, rejected, iterations, crack_length = numbers
        #: Time, s.
        self.time: float = time
        #: End of the run, s.
        self.end: float = end
        #: Length of the step, s.
        self.dt: float = dt
        #: Accepted steps so far.
        self.steps: int = steps
        #: Rejected steps so far.
        self.rejected: int = rejected
        #: Iterations of the linear solver in the step.
        self.iterations: int = iterations
        #: Length of all cracks, m (area in space, m²); with damage.
        self.crack_length: Optional[float] = crack_length

    @property
    def history(self) -> History:
        """The history of the run so far."""
        return self._simulation.history

    @property
    def fields(self) -> Fields:
        """Fields after this step; to be asked for while the run waits here, and then kept."""
        if self._fields is None:
            if self._simulation._step is not self:
                raise StateError(f"the run has gone on from t = {self.time:g} s; ask for its fields while it waits there")
            self._fields = self._simulation._read_fields(self.time)
        return self._fields

    @property
    def positions(self) -> Array:
        """Coordinates of the points, m. Shape ``(n, dimension)``."""
        return self._simulation.positions

    def stop(self, reason: str = "stopped") -> None:
        """Ends the run here as it would at its end: with a summary, pictures, and a checkpoint to go on from."""
        self._simulation._stop = reason

    def __repr__(self) -> str:
        return f"<perifrac.Step {self.steps} to t = {self.time:g} s of {self.end:g} s>"


class Simulation:
    """A scene that is run.

    ``threads`` is the number of threads (all processors by default), which changes no bit of the results. Files go
    into the folder ``out``; without one they go into a temporary folder that lives as long as the simulation and its
    runs, and with ``out=False`` there are none: neither a report nor a way to go on after a stop. ``loads`` are made
    by :func:`perifrac.source` and :func:`perifrac.force`.

    A run is computed on a thread of its own, so that other threads of Python go on meanwhile. Ctrl-C stops it between
    iterations, writes its state and raises :class:`KeyboardInterrupt`; :meth:`run` then goes on from there.
    """

    def __init__(
        self,
        scene: SceneLike,
        *,
        threads: Optional[int] = None,
        out: Union[_Path, bool, None] = None,
        loads: Sequence[Load] = (),
        checkpoint_every: Optional[float] = 600.0,
        checkpoint_at_outputs: bool = False,
    ) -> None:
        self._clear()
        #: The scene, as it was when the simulation was made.
        self.scene: Scene = as_scene(scene).copy()
        self._recipe = self.scene._recipe()
        self._threads = _whole(threads)
        self._loads = [load.parts() for load in loads]
        self._checkpoints = (checkpoint_every, checkpoint_at_outputs)
        if self._recipe.stages() is not None:
            raise UsageError(
                "the scene has stages, and a simulation is one run; make one of each of scene.stages(), with the folder "
                'of the one before as its key "start.from"'
            )
        self._steady = json.loads(self._recipe.json()).get("time", {}).get("mode") == "steady"
        self._keep: Optional[Folder] = None
        self._folder = self._folder_of(out)

    def _clear(self) -> None:
        self._session: Any = None
        self._from: Optional[Path] = None
        self._ground: Optional[Ground] = None
        self._history = History()
        self._step: Optional[Step] = None
        self._stop: Optional[str] = None
        self._run: Optional[Run] = None
        self._warnings: List[str] = []
        self._interrupted = False

    def _folder_of(self, out: Union[_Path, bool, None]) -> Optional[Path]:
        if out is False:
            return None
        if out is None or out is True:
            self._keep = Folder()
            return self._keep.path / self.scene.name
        return Path(out)

    @classmethod
    def resume(cls, path: _Path, scene: Optional[SceneLike] = None, **options: Any) -> "Simulation":
        """Goes on with the run in a folder, from its newest checkpoint or from the file that is named, to the same bits
        as without the stop.

        A run with points or loads of a program needs its ``scene``, and its ``loads`` among the options, which are
        those of :class:`Simulation` but for ``out``.
        """
        file, case, text, base, *_ = _perifrac.checkpoint(Path(path))
        folder = Path(path) if Path(path).is_dir() else Path(path).parent
        own = Scene._of_layers(case, [(str(file), text)], base) if scene is None else as_scene(scene)
        if scene is not None and own.to_toml() != (folder / "resolved.toml").read_text(encoding="utf-8"):
            raise CheckpointError(f"{file}: the run in {folder} is of another scene; give the one that it was begun with")
        simulation = cls(own, out=folder, **options)
        simulation._from = file
        return simulation

    @property
    def folder(self) -> Optional[Path]:
        """Folder of the files; nothing without."""
        return self._folder

    @property
    def history(self) -> History:
        """The history so far."""
        return self._history

    @property
    def time(self) -> float:
        """Time of the state at which the run stands, s."""
        if self._run is not None:
            return self._run.time
        return 0.0 if self._step is None else self._step.time

    @property
    def positions(self) -> Array:
        """Coordinates of the points, m. Shape ``(n, dimension)``."""
        self._open()
        if self._ground is None:
            raise StateError("a run that goes on has its points after its first step")
        return self._ground.positions

    @property
    def fields(self) -> Fields:
        """Fields of the state at which the run stands."""
        if self._run is not None:
            return self._run.fields
        self._open()
        return self._step.fields if self._step is not None else self._read_fields(0.0)

    @property
    def result(self) -> Optional[Run]:
        """The run, once it has ended or was stopped."""
        return self._run

    @property
    def warnings(self) -> List[str]:
        """Doubts that arose so far."""
        return list(self._warnings)

    def step(self) -> Optional[Step]:
        """Goes on to the next accepted step; nothing if the run has ended, at its end or because it was stopped."""
        if self._is_over():
            return None
        if self._stop is not None:
            self._conclude()
            return None
        fresh = self._open()
        if fresh and self._steady:
            return self._step
        got = self._advance()
        if got is None:
            self._end()
            return None
        return self._take(*got)

    def __iter__(self) -> Iterator[Step]:
        return self

    def __next__(self) -> Step:
        step = self.step()
        if step is None:
            raise StopIteration
        return step

    def run(self, on_step: Optional[Callable[[Step], Any]] = None, *, progress: bool = False) -> Run:
        """Runs to the end from wherever the simulation stands, also after a stop.

        ``on_step`` is called after every step, where it may look at everything and stop the run. ``progress`` shows a
        line in a terminal or a notebook.
        """
        if self._run is not None and self._run.stopped is not None:
            self._go_on()
        if on_step is None and not progress:
            self._run_through()
        else:
            with Progress(progress) as line:
                for step in self:
                    line.show(step)
                    if on_step is not None:
                        on_step(step)
        if self._run is None:
            raise StateError("the run has not ended")
        return self._run

    def _run_through(self) -> None:
        if self._is_over():
            return
        if self._stop is not None:
            self._conclude()
            return
        self._open()
        self._through(self._session.finish)

    def _conclude(self) -> None:
        """Ends the run where it waits."""
        self._through(self._session.enough)

    def _through(self, how: Callable[[List[List[float]]], None]) -> None:
        rows: List[List[float]] = []
        self._step = None
        try:
            self._guarded(how, rows)
        finally:
            self._append(rows + self._session.late())
        self._end()

    def _advance(self) -> Any:
        """To the next state. A run that is stopped on its way may have reached that state."""
        try:
            return self._guarded(self._session.advance)
        except BaseException:
            self._append(self._session.late())
            raise

    def _append(self, rows: List[List[float]]) -> None:
        self._look_around()
        for row in rows:
            self._history._append(row)

    def _is_over(self) -> bool:
        if self._run is not None and self._run.stopped is not None and self._stop is None:
            self._go_on()
        return self._run is not None

    def _go_on(self) -> None:
        """Makes ready to go on from the checkpoint that a stopped run left."""
        told, checkpoint = self._warnings, None
        # A run that failed before its first state begins anew.
        if self._ground is not None:
            if self._folder is None:
                raise StateError("the run was stopped and kept no checkpoint; without out=False it could go on")
            checkpoint = _perifrac.checkpoint(self._folder)[0]
        self._clear()
        self._warnings, self._from = told, checkpoint

    def _open(self) -> bool:
        """Begins the run; whether it was not begun before."""
        if self._session is not None:
            return False
        files = None if self._folder is None else (self._folder, self._from, *self._checkpoints)
        if self._from is not None and self._folder is not None:
            self._history._read(self._folder / "history.csv")
            _cut(self._history, _perifrac.checkpoint(self._from)[4])
        self._session = _perifrac.Session(self._recipe, self._loads, self._threads, files)
        if self._interrupted:
            self._session.interrupt()
        if self._from is not None:
            return True
        numbers, row = self._advance()
        self._take(numbers or (0.0, 0.0, 0.0, 0, 0, 0, None), row)
        return True

    def _take(self, numbers: _Numbers, row: List[float]) -> Step:
        self._look_around()
        self._history._append(row)
        self._step = Step(self, numbers)
        return self._step

    def _look_around(self) -> None:
        if self._ground is None and self._session is not None:
            told = self._session.ground()
            if told is not None:
                dimension, positions, cells, columns = told
                self._ground = Ground(dimension, positions, cells)
                self._history._begin(columns)

    def _read_fields(self, time: float) -> Fields:
        values, units = self._session.fields()
        return Fields(values, units, self._ground, time)

    def _guarded(self, call: Callable[..., Any], *words: Any) -> Any:
        """Calls into the run; what ends it leaves its last state behind."""
        try:
            return call(*words)
        except BaseException as error:
            self._fail(error)
            raise
        finally:
            self._warn()

    def _warn(self) -> None:
        for message in self._session.warnings():
            self._warnings.append(message)
            warnings.warn(message, PerifracWarning, stacklevel=5)

    def _fail(self, error: BaseException) -> None:
        if self._session.end_time() is None:
            return
        reason = "Ctrl-C" if isinstance(error, KeyboardInterrupt) else type(error).__name__
        self._end(reason)
        if isinstance(error, RunError):
            error.run = self._run

    def _end(self, reason: Optional[str] = None) -> None:
        self._look_around()
        self._step = None
        summary = self._session.summary()
        self._run = Run(
            self._read_fields(self._session.end_time() or 0.0),
            self._history,
            None if summary is None else json.loads(summary),
            self._folder,
            reason or self._stop,
            self._warnings,
            None if self._ground is None else self._ground.positions,
            self._keep,
        )

    def interrupt(self) -> None:
        """Stops the run as soon as it can, from any thread: who waits for it gets :class:`Interrupted`."""
        self._interrupted = True
        if self._session is not None:
            self._session.interrupt()

    def close(self) -> None:
        """Stops the run if it still goes on, and frees its threads, memory and folder."""
        if self._session is not None:
            self._session.close()

    def __enter__(self) -> "Simulation":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __del__(self) -> None:
        try:
            self.close()
        except Exception:  # the interpreter may be half gone
            pass

    def __repr__(self) -> str:
        return f"<perifrac.Simulation of {self.scene.name} at t = {self.time:g} s>"


def _whole(threads: Optional[int]) -> Optional[int]:
    if threads is not None and threads < 1:
        raise UsageError(f"threads is {threads}; at least 1 is needed")
    return threads


def _cut(history: History, time: float) -> None:
    """Leaves rows away that came after a checkpoint."""
    kept = int((history["time"] <= time).sum())
    history._count = kept
