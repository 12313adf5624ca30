"""Temporary folders that live as long as who holds them."""

from __future__ import annotations

import shutil
import tempfile
import weakref
from pathlib import Path


class Folder:
    """A folder that is removed with the last object that holds it."""

    def __init__(self) -> None:
        self.path = Path(tempfile.mkdtemp(prefix="perifrac-"))
        weakref.finalize(self, shutil.rmtree, self.path, True)
