"""Packages that are used where they are installed."""

from __future__ import annotations

import importlib
from typing import Any

from .errors import MissingPackage


def optional(package: str, purpose: str, install: str = "") -> Any:
    """The package, or an error that says what it is needed for and how to get it."""
    try:
        return importlib.import_module(package)
    except ImportError as error:
        name = install or package.split(".")[0]
        raise MissingPackage(f"{purpose} needs {name}, which is not installed: pip install {name}") from error
