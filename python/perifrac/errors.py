"""What can go wrong, by whose fault. Every class has the exit code with which the program ``perifrac`` ends for it."""

from __future__ import annotations

from typing import TYPE_CHECKING, List, Optional, Tuple

if TYPE_CHECKING:
    from ._run import Run

__all__ = [
    "CheckpointError",
    "CloudError",
    "Interrupted",
    "LoadError",
    "MissingPackage",
    "NotConverged",
    "OutputError",
    "PerifracError",
    "PerifracWarning",
    "PlanError",
    "RefusedError",
    "RunError",
    "SceneError",
    "SolverUnavailable",
    "StateError",
    "UsageError",
]


class PerifracError(Exception):
    """Any error of this package."""

    exit_code: int = 1


class UsageError(PerifracError, ValueError):
    """A name or a number that cannot be meant."""

    exit_code = 2


class SceneError(PerifracError, ValueError):
    """The scene has faults; the message underlines each at its place."""

    exit_code = 3
    #: Message of each fault, and what to do about it.
    diagnostics: List[Tuple[str, Optional[str]]] = []


class PlanError(SceneError):
    """The scene is sound by itself and does not fit its points."""


class RefusedError(PlanError):
    """Scheme, solver and scene cannot be combined."""


class CloudError(PerifracError, ValueError):
    """Points or values of the program that cannot be used."""

    exit_code = 3


class LoadError(PerifracError, ValueError):
    """A load in Python gave values that cannot be used."""


class RunError(PerifracError):
    """A run that did not reach its end."""

    #: The run up to its last good state, if it had one.
    run: Optional["Run"] = None


class NotConverged(RunError):
    """A step failed and could not be cut further, or misses a balance that the scene asks for."""

    exit_code = 4


class OutputError(RunError):
    """A file could not be written or read."""


class CheckpointError(RunError):
    """There is no checkpoint to go on from, or it does not fit."""


class SolverUnavailable(RunError):
    """The solver is in a library that is not there."""

    exit_code = 2


class Interrupted(RunError):
    """The run was stopped from outside; it can go on from its folder."""

    exit_code = 130


class StateError(PerifracError, RuntimeError):
    """What is asked for is not there at this moment of a run."""


class MissingPackage(PerifracError, ImportError):
    """An optional package is not installed."""


class PerifracWarning(UserWarning):
    """A doubt that arose in a run."""
