"""Scenes: what is computed."""

from __future__ import annotations

import difflib
import html
import json
import os
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Tuple, Union

import numpy as np

from . import _perifrac, _toml
from ._cloud import Cloud
from ._folder import Folder
from .errors import UsageError

#: What a scene is made from.
SceneLike = Union["Scene", Mapping[str, Any], str, "os.PathLike[str]"]


class Scene:
    """A scene: a dict, a text in TOML, or the path of a file; :func:`perifrac.case` makes one from a bundled case.

    Keys are read and changed by their path, ``scene["fluid.viscosity"] = "5 mPa s"``; a bare number is SI. Nothing is
    checked before the scene is planned or run.
    """

    def __init__(self, source: SceneLike, *, base: Union[str, "os.PathLike[str]", None] = None) -> None:
        #: Points in place of those of ``[geometry]``, of which only ``bounds`` then counts.
        self.cloud: Optional[Cloud] = None
        self._changes: Dict[str, str] = {}
        self._files: List[Folder] = []
        self._case = "scene"
        self._base = Path(base) if base is not None else Path()
        if isinstance(source, Scene):
            self.__dict__.update(source.copy().__dict__)
        elif isinstance(source, Mapping):
            self._layers = [("scene", _toml.document(_with_files(source, self._file)))]
        elif isinstance(source, str) and ("\n" in source or "=" in source):
            self._layers = [("scene", source)]
        else:
            self._read(Path(source))

    def _read(self, path: Path) -> None:
        self._layers, self._base = _perifrac.file_layers(path)
        folder, stem = path.resolve().parent.name, path.stem
        if len(self._layers) > 1:
            self._case = f"{folder}-{stem}"
        else:
            self._case = folder if stem == "scene" else stem

    @classmethod
    def _of_layers(cls, case: str, layers: List[Tuple[str, str]], base: Path) -> "Scene":
        scene = cls({}, base=base)
        scene._case, scene._layers = case, layers
        return scene

    @property
    def name(self) -> str:
        """Name of the case in reports and folders."""
        return self._case

    def __setitem__(self, key: str, value: Any) -> None:
        value = _with_files({key: value}, self._file)[key]
        # The last change of a key counts, in the order in which they were made.
        self._changes.pop(key, None)
        self._changes[key] = _toml.literal(value, key)

    def __getitem__(self, key: str) -> Any:
        found: Any = self.to_dict()
        for part in key.split("."):
            if not isinstance(found, Mapping) or part not in found:
                raise KeyError(f"the scene does not say {key!r}")
            found = found[part]
        return found

    def __contains__(self, key: str) -> bool:
        try:
            self[key]
        except KeyError:
            return False
        return True

    def update(self, changes: Mapping[str, Any]) -> "Scene":
        """Changes several keys; gives the scene itself."""
        for key, value in changes.items():
            self[key] = value
        return self

    def changed(self, changes: Mapping[str, Any]) -> "Scene":
        """A copy with these keys changed."""
        return self.copy().update(changes)

    def copy(self) -> "Scene":
        """A scene of its own with the same content."""
        own = Scene.__new__(Scene)
        own.__dict__.update(self.__dict__)
        own._changes, own._layers = dict(self._changes), list(self._layers)
        own._files = list(self._files)
        return own

    def to_toml(self) -> str:
        """The scene with all changes as TOML; faults raise :class:`~perifrac.errors.SceneError`."""
        return self._recipe().resolved()

    def to_dict(self) -> Dict[str, Any]:
        """The same as a dict."""
        told: Dict[str, Any] = json.loads(self._recipe().json())
        return told

    def stages(self) -> List["Scene"]:
        """The stages of a scene that has ``[[stages]]``, as scenes of their own.

        Each goes on from the folder that its key ``start.from`` names: set it to the folder of the run before.
        """
        found = self._recipe().stages() or []
        return [Scene._of_layers(name, [(name, text)], self._base) for name, text in found]

    def _recipe(self) -> _perifrac.Recipe:
        cloud = None if self.cloud is None else self.cloud.parts()
        return _perifrac.Recipe(self._case, self._layers, self._base, list(self._changes.items()), cloud)

    def _file(self, array: Any) -> str:
        """Keeps an array in a file that lives as long as the scene and its copies."""
        folder = Folder()
        self._files.append(folder)
        path = folder.path / "values.npy"
        np.save(path, np.asarray(array, dtype=np.float64))
        return str(path)

    def __repr__(self) -> str:
        changes = "".join(f", {key} = {value}" for key, value in self._changes.items())
        return f"<perifrac.Scene {self._case}{changes}>"

    def _repr_html_(self) -> str:
        text = html.escape(self.to_toml())
        name = html.escape(self._case)
        return f"<details><summary>scene <b>{name}</b></summary><pre>{text}</pre></details>"


def _with_files(values: Mapping[str, Any], keep: Any) -> Dict[str, Any]:
    """Values in which arrays of permeabilities are names of files that hold them."""

    def replaced(key: str, value: Any) -> Any:
        if isinstance(value, Mapping):
            return {name: replaced(str(name), own) for name, own in value.items()}
        if isinstance(value, np.ndarray) and key.split(".")[-1] == "permeability" and value.ndim:
            return {"file": keep(value)}
        return value

    return {key: replaced(key, value) for key, value in values.items()}


def as_scene(scene: SceneLike) -> Scene:
    """A scene from whatever one can be made from; a bare name is that of a bundled case."""
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, str) and "\n" not in scene and "=" not in scene and not Path(scene).is_file():
        if not scene.endswith(".toml"):
            return case(scene)
    return Scene(scene)


def case(name: str) -> Scene:
    """A bundled case, ``"terzaghi"``, or a variant of one, ``"natural-fractures/smoke"``; see :func:`cases`."""
    own, _, variant = name.partition("/")
    known = {found.name: found for found in cases()}
    if own not in known:
        close = difflib.get_close_matches(own, known, n=1)
        guess = f"; did you mean {close[0]}?" if close else ""
        raise UsageError(f'there is no bundled case called "{own}"{guess} (bundled: {", ".join(known)})')
    layers = _perifrac.case_layers(own, variant or None)
    if layers is None:
        there = ", ".join(known[own].variants) or "none"
        raise UsageError(f'the bundled case "{own}" has no variant "{variant}": it has {there}')
    return Scene._of_layers(name.replace("/", "-"), layers, Path())


class Case:
    """A bundled case."""

    def __init__(self, name: str, summary: str, readme: str, variants: List[str]) -> None:
        self.name = name
        #: One line about it.
        self.summary = summary
        #: What to expect of it, as Markdown.
        self.readme = readme
        #: Names of its variants: ``case("NAME/VARIANT")``.
        self.variants = variants

    def __repr__(self) -> str:
        variants = f" ({', '.join(self.variants)})" if self.variants else ""
        return f"<{self.name}{variants}: {self.summary}>"


def cases() -> List[Case]:
    """All bundled cases."""
    return [Case(*told) for told in _perifrac.cases()]


class Plan(str):
    """What will run, why, how large, and the limits of the step, as text; ``data`` has the figures."""

    #: The same as ``perifrac plan --json`` prints.
    data: Dict[str, Any]
    #: Doubts about it.
    warnings: List[str]

    def __repr__(self) -> str:
        return str(self)


def plan(scene: SceneLike) -> Plan:
    """What a scene will do and cost; raises what a run would be refused for."""
    text, data, warnings, _ = as_scene(scene)._recipe().plan()
    told = Plan(text)
    told.data, told.warnings = json.loads(data), warnings
    return told


def check(scene: SceneLike) -> List[str]:
    """Checks a scene, its files and its points; gives the doubts and raises the faults."""
    return plan(scene).warnings
