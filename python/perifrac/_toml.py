"""Values of Python as TOML."""

from __future__ import annotations

import json
import math
import re
from typing import Any, List, Mapping, Tuple

import numpy as np

from .errors import UsageError

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def literal(value: Any, key: str = "value") -> str:
    """A value as it stands after ``=`` in TOML.

    Texts are quantities with a unit or names, numbers are SI; numpy's numbers and arrays are as good as Python's.
    """
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return _number(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(literal(entry, key) for entry in value) + "]"
    if isinstance(value, Mapping):
        entries = (f"{_key(name)} = {literal(entry, f'{key}.{name}')}" for name, entry in value.items())
        return "{" + ", ".join(entries) + "}"
    raise UsageError(
        f"{key}: a scene cannot hold {value!r} of type {type(value).__name__}; give a text with a unit, a number, "
        "a bool, a list or a dict"
    )


def document(scene: Mapping[str, Any]) -> str:
    """A dict of a scene as a text in TOML, one key or section a line as far as they go."""
    lines: List[str] = []
    _section(lines, (), scene)
    return "\n".join(lines).strip() + "\n"


def _section(lines: List[str], path: Tuple[str, ...], table: Mapping[str, Any]) -> None:
    plain = {key: value for key, value in table.items() if not _is_section(value)}
    if path and (plain or not table):
        lines.append("[" + ".".join(_key(part) for part in path) + "]")
    for key, value in plain.items():
        lines.append(f"{_key(key)} = {literal(value, '.'.join((*path, str(key))))}")
    if plain or (path and not table):
        lines.append("")
    for key, value in table.items():
        if isinstance(value, Mapping) and _is_section(value):
            _section(lines, (*path, str(key)), value)
        elif _is_section(value):
            for entry in value:
                lines.append("[[" + ".".join(_key(part) for part in (*path, str(key))) + "]]")
                inner = [f"{_key(name)} = {literal(own, str(name))}" for name, own in entry.items()]
                lines.extend([*inner, ""])


def _is_section(value: Any) -> bool:
    if isinstance(value, Mapping):
        return True
    return isinstance(value, (list, tuple)) and bool(value) and all(isinstance(entry, Mapping) for entry in value)


def _key(name: Any) -> str:
    text = str(name)
    return text if _BARE.fullmatch(text) else json.dumps(text, ensure_ascii=False)


def _number(value: float) -> str:
    if math.isnan(value):
        return "nan"
    if math.isinf(value):
        return "inf" if value > 0 else "-inf"
    return repr(value)
