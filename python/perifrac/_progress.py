"""A line that tells how far a run has come."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._simulation import Step

#: Seconds between two changes of the line.
_PAUSE = 0.1


class Progress:
    """One line on standard error, written over and over; terminals and notebooks show it alike."""

    def __init__(self, wanted: bool) -> None:
        self._wanted = wanted
        self._shown = 0.0
        self._width = 0

    def __enter__(self) -> "Progress":
        return self

    def show(self, step: "Step") -> None:
        """Tells of a step."""
        now = time.monotonic()
        last = step.time >= step.end
        if not self._wanted or (now - self._shown < _PAUSE and not last):
            return
        self._shown = now
        done = step.time / step.end if step.end else 1.0
        bar = "█" * int(24 * done)
        text = f"{bar:24} {done:4.0%}  t = {step.time:.3e} s, Δt = {step.dt:.1e} s, {step.steps} steps"
        self._width = max(self._width, len(text))
        sys.stderr.write(f"\r{text:{self._width}}")
        sys.stderr.flush()

    def __exit__(self, *_: Any) -> None:
        if self._width:
            sys.stderr.write("\n")
