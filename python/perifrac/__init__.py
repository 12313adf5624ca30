"""Implicit peridynamics for porous rock: flow, poroelasticity, fracture.

>>> import perifrac as pf
>>> scene = pf.case("two-layer")
>>> scene["materials.left.permeability"] = 1e6
>>> run = pf.Simulation(scene).run()
>>> run.errors["pressure"]["l2"] < 1e-3
True
"""

from ._cloud import Cloud
from ._fields import Fields
from ._history import History
from ._loads import Load, Points, force, source
from ._perifrac import __version__
from ._run import Run
from ._scene import Case, Plan, Scene, case, cases, check, plan
from ._simulation import Simulation, Step
from ._sweep import Table, sweep
from .errors import (
    CheckpointError,
    CloudError,
    Interrupted,
    LoadError,
    MissingPackage,
    NotConverged,
    OutputError,
    PerifracError,
    PerifracWarning,
    PlanError,
    RefusedError,
    RunError,
    SceneError,
    SolverUnavailable,
    StateError,
    UsageError,
)

__all__ = [
    "Case",
    "CheckpointError",
    "Cloud",
    "CloudError",
    "Fields",
    "History",
    "Interrupted",
    "Load",
    "LoadError",
    "MissingPackage",
    "NotConverged",
    "OutputError",
    "PerifracError",
    "PerifracWarning",
    "Plan",
    "PlanError",
    "Points",
    "RefusedError",
    "Run",
    "RunError",
    "Scene",
    "SceneError",
    "Simulation",
    "SolverUnavailable",
    "StateError",
    "Step",
    "Table",
    "UsageError",
    "__version__",
    "case",
    "cases",
    "check",
    "force",
    "plan",
    "source",
    "sweep",
]
