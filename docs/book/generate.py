#!/usr/bin/env python3
"""Puts the pages of the book together in target/book/pages, from docs/book and from runs of the program.

Generated: the references of keys and of columns from `perifrac schema`, the command line from `--help`, a page for every case with
the picture and the table of a run, and the gallery. Theory, combinations and decisions are taken from docs/.

    python3 docs/book/generate.py target/release/perifrac
"""

import concurrent.futures
import csv
import html
import json
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BOOK = ROOT / "docs" / "book"
OUT = ROOT / "target" / "book"
PAGES = OUT / "pages"

# How the run of a page is made: what is typed after `perifrac run`. Each takes a few seconds at most.
FORMS = {
    "five-spot": "five-spot --set geometry.points=[50,50]",
    "two-layer": "two-layer",
    "channel": "channel --set time.mode=steady",
    "barrier": "barrier",
    "inclusion": "inclusion",
    "heterogeneous": "heterogeneous --set geometry.points=[60,60]",
    "spe10-1": "spe10-1",
    "reservoir-3d": "reservoir-3d --set geometry.points=[10,10,5]",
    "theis": "theis --set geometry.points=[50,50]",
    "anisotropic": "anisotropic --set geometry.points=[50,50]",
    "well-test": "well-test/limited --set geometry.points=[50,50]",
    "terzaghi": "terzaghi --set time.step=3",
    "terzaghi-graded": "terzaghi-graded --set time.step=3",
    "terzaghi-tensor": "terzaghi-tensor --set time.step=3",
    "column-3d": "column-3d --set time.step=1",
    "mandel": "mandel",
    "footing": "footing",
    "layers-stiffness": "layers-stiffness",
    "sneddon": "sneddon --set geometry.spacing=0.01",
    "notched-tension": "notched-tension/smoke",
    "notched-shear": "notched-shear/smoke --set geometry.points=[24,24]",
    "pressurised-notch": "pressurised-notch/smoke --set geometry.spacing=0.025",
    "natural-fractures": "natural-fractures/smoke --set geometry.spacing=0.03",
    "injection-rate": "injection-rate/smoke --set geometry.spacing=0.03",
    "kgd-toughness": "kgd-toughness/smoke --set time.end=1",
    "kgd-viscosity": "kgd-viscosity/smoke",
    "kgd-leak-off": "kgd-leak-off/smoke",
    "breakdown": "breakdown/smoke",
    "inclined-injection": "inclined-injection/smoke",
    "two-cracks": "two-cracks/smoke --set time.end=0.3",
    "wing-cracks": "wing-cracks/smoke",
    "staged-injection": "staged-injection --set geometry.spacing=0.08",
    "penny-3d": "penny-3d/smoke",
    "penny-viscosity": "penny-viscosity/smoke",
    "manufactured": "manufactured",
}

# The scenes of the book itself.
OWN = {
    "strip-load": "strip-load.toml",
    "inclined-crack": "inclined-crack.toml",
    "injection": "injection.toml",
    "own-points": "own-points.toml",
    "own-mesh": "own-mesh.toml",
    "own-array": "own-array.toml",
}

# Pictures of a page, the first of each line that a run left.
FIELDS = ["damage-over-time.png", "03-inject/damage-over-time.png", "pressure-*.png", "displacement-*.png"]
CURVES = ["profile-*.svg", "crack-*.svg", "03-inject/crack-main.svg", "history-pressure.svg"]


class Fault(Exception):
    """What keeps the book from being built."""


def write(name, text):
    path = PAGES / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


# --------------------------------------------------------------------------------------------- runs


def run(program, name, typed, folder):
    """Runs what stands on a page; tells the seconds it took."""
    out = folder / name
    words = [str(program), "run", *typed.split(), "--threads", "1", "--out", str(out), "--quiet"]
    start = time.monotonic()
    done = subprocess.run(words, cwd=BOOK / "scenes", capture_output=True, text=True)
    if done.returncode != 0:
        raise Fault(f"perifrac run {typed}: exit code {done.returncode}\n{done.stderr}")
    return time.monotonic() - start


def runs(program, folder):
    """All runs of the book, as many at once as there are processors."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        every = {**OWN, **FORMS}
        # The longest first, so that none is left over at the end.
        heavy = ["natural-fractures", "injection", "injection-rate", "inclined-crack", "pressurised-notch"]
        names = sorted(every, key=lambda name: heavy.index(name) if name in heavy else len(heavy))
        waits = {name: pool.submit(run, program, name, every[name], folder) for name in names}
        return {name: wait.result() for name, wait in waits.items()}


# ------------------------------------------------------------------------------------ verification


def pictures(name, folder):
    """A field and a curve of a run, copied beside the pages; their paths from there."""
    found = []
    for patterns in (FIELDS, CURVES):
        for pattern in patterns:
            # The last output of a field; of curves the plainest name, which is that of the pressure.
            paths = sorted((folder / name).glob(pattern), reverse=patterns is FIELDS)
            paths = [path for path in paths if path.name != "crack-path.svg"]
            if paths:
                paths = paths if patterns is FIELDS else sorted(paths, key=lambda path: len(path.name))
                target = PAGES / "runs" / f"{name}-{paths[0].name}"
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(paths[0], target)
                found.append(f"runs/{target.name}")
                break
    return found


def figure(value, unit=""):
    if isinstance(value, float):
        value = f"{value:.3g}"
    return f"{value} {unit}".strip()


def errors_table(summary):
    rows = ["| at | field | error, root mean square over range | over norm | largest over range |", "|---|---|---|---|---|"]
    over_time = summary["errors_over_time"] or [{"time": summary["t_end"], **summary["errors"]}]
    for entry in over_time:
        for field, error in entry.items():
            if field != "time":
                values = " | ".join(f"{error[key]:.2e}" for key in ("l2", "l2_over_norm", "max"))
                rows.append(f"| {figure(float(entry['time']), 's')} | {field} | {values} |")
    return "\n".join(rows)


def figures_table(summary):
    units = summary["units"]
    rows = [("points", figure(summary["points"])), ("scheme", summary["scheme"]), ("solver", summary["solver"] or "–")]
    rows.append(("steps accepted, rejected", f"{summary['steps']}, {summary['rejected']}"))
    balance = summary["balance"]
    rows += [
        (told, f"{balance[key]:.1e}")
        for key, told in (
            ("mass", "mass balance"),
            ("momentum", "forces out of balance"),
            ("energy_error", "energy balance"),
        )
        if isinstance(balance.get(key), float)
    ]
    for key, value in (summary.get("results") or {}).items():
        if isinstance(value, (int, float)):
            rows.append((f"`results.{key}`", figure(float(value), units.get(f"results.{key}", ""))))
    return "| figure | value |\n|---|---|\n" + "\n".join(f"| {told} | {value} |" for told, value in rows)


def cases(program):
    """Names and summaries of the bundled cases, in their order."""
    listed = subprocess.run([program, "cases"], capture_output=True, text=True, check=True).stdout
    found = {}
    for line in listed.splitlines():
        name, about = line.split(maxsplit=1)
        about = re.split(r"\s+/\w", about)[0]
        found[name] = about
    return found


def verification(program, folder, known):
    unknown = set(known) ^ set(FORMS)
    if unknown:
        raise Fault(f"FORMS in generate.py and the bundled cases differ in {sorted(unknown)}")
    index = [
        "# Verification",
        "",
        "One page for every bundled case: what it shows, the figures to expect from it in full, and a run of a form"
        " that takes seconds, made for this book by the command on the page. The tests hold results against exact"
        " solutions, orders of convergence and balances; [their figures](#how-good-it-is) are below.",
        "",
        "| case | |",
        "|---|---|",
    ]
    for name, about in known.items():
        index.append(f"| [{name}]({name}.md) | {about} |")
        text = (ROOT / "cases" / name / "README.md").read_text(encoding="utf-8")
        text = re.sub(r"\.\./([\w-]+)/README\.md", r"\1.md", text)
        summary = json.loads((folder / name / "summary.json").read_text())
        parts = [text.rstrip(), "## A run of it", "```sh\n" + f"perifrac run {FORMS[name]}\n" + "```"]
        if summary["errors"]:
            parts.append("Distance from the exact solution:")
            parts.append(errors_table(summary))
        parts.append(figures_table(summary))
        for picture in pictures(name, folder):
            parts.append(f'![{html.escape(about)}](../{picture}){{ .run }}')
        if summary["warnings"]:
            parts.append("The run warned:")
            parts += [f"> {html.escape(warning)}" for warning in summary["warnings"]]
        parts.append(f"The scene (`perifrac cases --write {name}` copies it):")
        parts.append(f'```toml\n--8<-- "cases/{name}/scene.toml"\n```')
        write(f"verification/{name}.md", "\n\n".join(parts) + "\n")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    figures = readme.split("## How good it is")[1].split("\n## ")[0]
    figures = re.sub(r"\[(benches/README\.md)\]\([^)]*\)", r"`\1`", figures)
    write("verification/index.md", "\n".join(index) + "\n\n## How good it is" + figures)


def gallery(folder, known):
    parts = [
        "# Gallery",
        "",
        "Pictures as runs leave them. The page of each case has the command.",
        "",
        '<div class="gallery" markdown>',
        "",
    ]
    for name, about in known.items():
        shown = pictures(name, folder)
        if shown:
            parts += [
                "<figure markdown>",
                f"[![{html.escape(about)}]({shown[0]})](verification/{name}.md)",
                f"<figcaption markdown>[{name}](verification/{name}.md): {about}</figcaption>",
                "</figure>",
                "",
            ]
    parts += ["</div>", ""]
    parts += [
        "In full, `perifrac run natural-fractures/wide` draws this in ten minutes: fluid drives a crack into a fracture that was",
        "there before, which fills and grows on from its tips.",
        "",
        "![Damage over time where a pumped crack meets a natural fracture](img/natural-fractures-wide.png){ .run }",
    ]
    write("gallery.md", "\n".join(parts) + "\n")


# --------------------------------------------------------------------------------------- reference


class Keys:
    """The reference of keys from the schema."""

    def __init__(self, schema):
        self.schema = schema
        self.definitions = schema["definitions"]
        self.lines = []

    def resolve(self, node):
        """A node with its references followed; what it says itself goes before."""
        own = dict(node)
        while True:
            inner = None
            if "$ref" in own:
                inner = self.definitions[own.pop("$ref").rsplit("/", 1)[1]]
            elif len(own.get("allOf", [])) == 1:
                inner = own.pop("allOf")[0]
            elif "anyOf" in own:
                rest = [part for part in own["anyOf"] if part != {"type": "null"}]
                if len(rest) == 1:
                    own.pop("anyOf")
                    inner = rest[0]
            if inner is None:
                return own
            own = {**inner, **own}

    @staticmethod
    def quantity(node):
        """Name and unit of a quantity, from the text that describes it."""
        told = re.match(r"(an? [^:]*): a number in ([^,;]*), or a text", node.get("description", ""))
        return told and (re.sub(r"^an? ", "", told[1]), "" if told[2] == "1" else told[2])

    def definition_of(self, node):
        """The quantity that a node refers to, if it does."""
        inner = node
        while True:
            if "$ref" in inner:
                inner = self.definitions[inner["$ref"].rsplit("/", 1)[1]]
                if self.quantity(inner):
                    return self.quantity(inner)
            elif len(inner.get("allOf", [])) == 1:
                inner = inner["allOf"][0]
            elif "anyOf" in inner:
                rest = [part for part in inner["anyOf"] if part != {"type": "null"}]
                if len(rest) != 1:
                    return None
                inner = rest[0]
            else:
                return None

    def field(self, node):
        """What may stand for a property of the rock that may vary, told in full at the permeability; None for others."""
        variants = self.resolve(node).get("anyOf") or []
        tables = [self.resolve(part).get("properties", {}) for part in variants[1:]]
        if not 1 <= len(tables) <= 2 or not {"file", "cells"} <= tables[0].keys():
            return None
        forms = "a file" if len(tables) == 1 else "a file or a distribution"
        return f"{self.kind(variants[0])}; or {forms} as for `permeability`"

    def kind(self, node):
        """What may stand for a key, with its unit."""
        field = self.field(node)
        if field:
            return field
        quantity = self.definition_of(node)
        if quantity:
            return quantity[0] + (f", {quantity[1]}" if quantity[1] else "")
        own = self.resolve(node)
        if "const" in own:
            return f"`{json.dumps(own['const'])}`"
        if "enum" in own:
            return " or ".join(f"`{json.dumps(value)}`" for value in own["enum"])
        variants = own.get("oneOf") or own.get("anyOf") or []
        if variants and all("const" in self.resolve(part) for part in variants):
            return "a choice, below"
        if len(variants) == 2:
            quantity = self.definition_of(variants[0])
            inner = self.resolve(variants[1])
            if quantity and set(inner.get("properties", {})) == {"time", "value"}:
                return f"{quantity[0]}, {quantity[1]}; or `{{ time = […], value = […] }}`"
            if all(not self.resolve(part).get("properties") for part in variants):
                return " or ".join(self.kind(part) for part in variants)
        if variants:
            return "a table, below"
        types = own.get("type")
        types = [types] if isinstance(types, str) else [one for one in types or [] if one != "null"]
        if "array" in types:
            return "list of: " + self.kind(own["items"])
        if "object" in types:
            listed = own.get("properties") or isinstance(own.get("additionalProperties"), dict)
            return "a table, below" if listed else "a table"
        return {"string": "text", "boolean": "`true` or `false`", "integer": "whole number", "number": "number"}.get(
            types[0] if types else "", "any"
        )

    @staticmethod
    def range(own):
        low, high = own.get("minimum"), own.get("maximum")
        if own.get("exclusiveMaximum") is not None:
            return f"from {Keys.number(low)}, below {Keys.number(own['exclusiveMaximum'])}"
        if low is not None and high is not None:
            return f"{Keys.number(low)} … {Keys.number(high)}"
        if low:
            return f"≥ {Keys.number(low)}"
        return ""

    def default(self, key, own, required):
        if key in required:
            return "**needed**"
        value = own.get("default")
        if value is None:
            return "–"
        return f"`{Keys.number(value) if isinstance(value, float) else json.dumps(value)}`"

    @staticmethod
    def number(value):
        return f"{value:g}".replace("e+0", "e").replace("e+", "e").replace("e-0", "e-")

    @staticmethod
    def prose(text):
        text = re.sub(r"\s+", " ", text or "").strip()
        # The range has a column of its own; its reason stays.
        text = re.sub(r" ?From -?[0-9.e-]+ to [0-9.e-]+: ", " Range: ", text)
        return text.replace("|", "\\|")

    def table(self, path, node):
        """The keys of one table, then the tables and choices within."""
        properties, required = node.get("properties", {}), node.get("required", [])
        self.lines += ["| key | what | default | range | meaning |", "|---|---|---|---|---|"]
        # What must be there comes first.
        order = sorted(properties, key=lambda key: (key != "type", key not in required, key))
        properties = {key: properties[key] for key in order}
        for key, value in properties.items():
            own = self.resolve(value)
            told = value.get("description") or (own.get("description") if "const" not in own else "")
            if "const" in own and key == "type":
                told = "Which of these tables it is."
            if self.definition_of(value):
                told = value.get("description", "")
            self.lines.append(
                f"| `{key}` | {self.kind(value)} | {self.default(key, own, required)} | {self.range(own)} | {self.prose(told)} |"
            )
        self.lines.append("")
        for key, value in properties.items():
            self.within(f"{path}.{key}" if path else key, value)

    def within(self, path, node):
        """Choices and tables that stand under a key."""
        if self.definition_of(node) or self.field(node):
            return
        own = self.resolve(node)
        variants = own.get("oneOf") or own.get("anyOf") or []
        if variants and all("const" in self.resolve(part) for part in variants):
            self.lines += [f"Choices of `{path}`:", ""]
            for part in variants:
                self.lines.append(f"- `{json.dumps(part['const'])}`: {self.prose(part.get('description', ''))}")
            self.lines.append("")
            return
        tables = [self.resolve(part) for part in variants]
        tables = [part for part in tables if part.get("properties") and set(part["properties"]) != {"time", "value"}]
        if tables:
            if "half-plane" in [part["properties"].get("type", {}).get("const") for part in tables]:
                self.lines += [f"`{path}` is a [part of space](#parts-of-space).", ""]
                return
            self.lines += [f"`{path}`: {self.prose(own.get('description'))}", ""]
            values = [part for part in variants if not self.resolve(part).get("properties")]
            self.lines += [f"- {self.kind(part)}: {self.prose(part.get('description'))}" for part in values] + [""]
            for part in tables:
                self.lines += [f"*{self.prose(part.get('description'))}*", ""]
                self.table(path, part)
            return
        kinds = own.get("type")
        if own.get("properties"):
            if own["properties"].keys() >= {"left", "right", "top"}:
                sides = ", ".join(
                    f"`{side}` ({value['description'].rstrip('.').lower()})" for side, value in own["properties"].items()
                )
                self.lines += [f"#### `[{path}.SIDE]`", "", f"{self.prose(own.get('description'))} SIDE is one of {sides}.", ""]
                self.within(f"{path}.SIDE", {k: v for k, v in own["properties"]["left"].items() if k != "description"})
                return
            self.lines += [f"#### `[{path}]`", ""]
            self.table(path, own)
        elif isinstance(own.get("additionalProperties"), dict):
            inner = self.resolve(own["additionalProperties"])
            self.lines += [f"#### `[{path}.NAME]`", "", f"{self.prose(inner.get('description'))} NAME is yours.", ""]
            self.table(f"{path}.NAME", inner)
        elif kinds == "array" or (isinstance(kinds, list) and "array" in kinds):
            inner = self.resolve(own["items"])
            if inner.get("properties"):
                self.lines += [f"#### `[[{path}]]`", "", self.prose(inner.get("description")), ""]
                self.table(path, inner)

    def page(self):
        schema = self.schema
        self.lines += [
            "---\nsearch:\n  boost: 4\n---\n",
            "# Every key of a scene",
            "",
            "Made from `perifrac schema`, which also serves editors. " + self.prose(schema.get("description")),
            "",
            "A range is that of the value in SI units. A dash for a default means that without the key nothing is set: its"
            " meaning says what then holds. A path such as `flow.boundary.left.pressure` is what `--set` takes.",
            "",
        ]
        plain = {key: value for key, value in schema["properties"].items() if not self.is_section(value)}
        order = [
            "geometry", "horizon", "fluid", "materials", "gravity", "initial", "flow", "wells", "mechanics", "coupling",
            "damage", "fracture_flow", "cracks", "start", "time", "scheme", "solver", "audit", "output", "reference",
        ]
        sections = [key for key in schema["properties"] if key not in plain]
        if set(order) != set(sections):
            raise Fault(f"sections of the schema are not those of generate.py: {set(order) ^ set(sections)}")
        self.lines += ["## Before the sections", ""]
        self.table("", {"properties": plain, "required": schema["required"]})
        shape = self.definitions["Shape"]
        for key in order:
            value = schema["properties"][key]
            own = self.resolve(value)
            needed = " Every scene has one." if key in schema["required"] else ""
            self.lines += [f"## `[{key}]`", "", self.prose(value.get("description") or own.get("description")) + needed, ""]
            own.pop("description", None)
            if own.get("oneOf"):
                for part in own["oneOf"]:
                    part = self.resolve(part)
                    told = part["properties"]["type"]["const"]
                    self.lines += [f"### {key}.type = \"{told}\"", "", self.prose(part.get("description")), ""]
                    self.table(key, part)
            elif own.get("properties"):
                self.table(key, own)
            else:
                inner = self.resolve(own["additionalProperties"])
                self.lines += [f"### `[{key}.NAME]`", "", f"{self.prose(inner.get('description'))} NAME is yours.", ""]
                self.table(f"{key}.NAME", inner)
        self.lines += ["## Parts of space", "", self.prose(shape["description"]), ""]
        for part in shape["oneOf"]:
            told = part["properties"]["type"]["const"]
            self.lines += [f"### type = \"{told}\"", "", self.prose(part.get("description")), ""]
            self.table("region", part)
        self.units()
        return "\n".join(self.lines) + "\n"

    def is_section(self, node):
        own = self.resolve(node)
        return bool(own.get("properties") or own.get("oneOf") or isinstance(own.get("additionalProperties"), dict))

    def units(self):
        self.lines += ["## Quantities and units", "", "| quantity | SI unit | example | symbols |", "|---|---|---|---|"]
        for node in self.definitions.values():
            found = self.quantity(node)
            if found:
                example = re.search(r'such as "([^"]*)"', node["description"])
                symbols = re.search(r"symbols: (.*)$", node["description"])
                symbols = symbols[1] if symbols else "–"
                self.lines.append(f"| {found[0]} | {found[1] or '1'} | `\"{example[1]}\"` | {symbols} |")
        self.lines.append("")


# ------------------------------------------------------------------------------------ command line


def commands(program):
    def told(*words):
        text = subprocess.run([program, *words], capture_output=True, text=True, check=True).stdout
        return re.sub(rf"\b{re.escape(Path(program).name)}\b", "perifrac", text).rstrip()

    parts = ["# The command line", "As `perifrac --help` and the help of every verb print it.", f"```text\n{told('--help')}\n```"]
    for verb in ("run", "resume", "plan", "check", "study", "report", "cases", "schemes", "solvers", "schema", "completions", "man"):
        parts += [f"## perifrac {verb}", f"```text\n{told(verb, '--help')}\n```"]
    write("commands.md", "\n\n".join(parts) + "\n")
    text = told("solvers")
    write(
        "solvers.md",
        "# Solvers\n\nWhat `perifrac solvers` prints. [Choosing](choosing.md#solver) says which to take; "
        "`auto` is right nearly always.\n\n```text\n" + text + "\n```\n",
    )


# ----------------------------------------------------------------------------------------- columns


TABLES = {
    "history.csv": "One row for the start and for every step.",
    "profile-NAME.csv": "One row for every place along a line of the scene, at every output.",
    "crack-NAME.csv": "One row for every place along a crack, at every output.",
    "KIND.csv": "The table of a [study](studies.md), `cost.csv` and so on: one row for every run of every method.",
}


def columns(program):
    """The page of every column of every table."""
    told = subprocess.run([program, "schema", "--columns"], capture_output=True, text=True, check=True).stdout
    known = json.loads(told)
    lines = [
        "---\nsearch:\n  boost: 4\n---\n",
        "# Every column of a table",
        "",
        "Made from `perifrac schema --columns`. PROBE, CRACK, WELL and NAME stand for names of the scene, SIDE for `left` … `back`, AXIS for"
        " `x`, `y` or `z`, NUMBER for a number from 1. In two dimensions rates, volumes, forces and energies are those of the slab of"
        " `geometry.thickness`.",
        "",
    ]
    if {column["file"] for column in known} != set(TABLES):
        raise Fault("files of `perifrac schema --columns` are not those of generate.py")
    for file, told in TABLES.items():
        lines += [f"## {file}", "", told, "", "| column | unit | with | meaning |", "|---|---|---|---|"]
        for column in known:
            if column["file"] == file:
                unit = column["unit"].replace("^2", "²").replace("^3", "³") or "text"
                lines.append(f"| `{column['name']}` | {unit} | {column['with']} | {column['meaning']} |")
        lines.append("")
    write("columns.md", "\n".join(lines))


def written(folder):
    """Every column of every table of every run is told of in its summary, with a meaning."""
    checked = 0
    for path in sorted(folder.rglob("*.csv")):
        summary = json.loads((path.parent / "summary.json").read_text(encoding="utf-8"))
        own = [column for column in summary["columns"] if column["file"] == path.name]
        with open(path, newline="") as file:
            header = next(csv.reader(file))
        if header != [column["name"] for column in own] or not all(column["meaning"] for column in own):
            raise Fault(f"{path}: the list of columns does not tell of all of {header}")
        checked += len(header)
    return checked


# --------------------------------------------------------------------------------------- the whole


def copied():
    """Pages, theory, combinations, decisions and pictures."""
    shutil.rmtree(PAGES, ignore_errors=True)
    shutil.copytree(BOOK / "pages", PAGES)
    shutil.copytree(BOOK / "theme", PAGES / "theme")
    shutil.copytree(BOOK / "scenes", PAGES / "scenes")
    shutil.copytree(ROOT / "docs" / "img", PAGES / "img")
    shutil.copytree(ROOT / "docs" / "adr", PAGES / "adr")
    for name in ("theory.md", "combinations.md"):
        shutil.copy(ROOT / "docs" / name, PAGES / name)
    decisions = sorted((ROOT / "docs" / "adr").glob("*.md"))
    lines = ["# Decisions", "", "Choices that a later reader might undo for want of their reasons, one a page.", ""]
    for path in decisions:
        title = path.read_text(encoding="utf-8").splitlines()[0].lstrip("# ")
        lines.append(f"- [{title}]({path.name})")
    write("adr/index.md", "\n".join(lines) + "\n")
    return decisions


def navigation(known, decisions):
    text = (BOOK / "mkdocs.yml").read_text(encoding="utf-8")

    def pages(title, folder, names):
        entries = [f"      - {title}:", f"          - {folder}/index.md"]
        return "\n".join(entries + [f"          - {folder}/{name}" for name in names])

    for title, folder, names in (
        ("Verification", "verification", [f"{name}.md" for name in known]),
        ("Decisions", "adr", [path.name for path in decisions]),
    ):
        line = f"      - {title}: {folder}"
        if line not in text:
            raise Fault(f"mkdocs.yml has no line `{line}`")
        text = text.replace(line, pages(title, folder, names))
    (OUT / "mkdocs.yml").write_text(text, encoding="utf-8")


def main():
    program = Path(sys.argv[1]).resolve()
    if not program.exists():
        raise Fault(f"there is no program {program}; build it with `cargo build --release`")
    OUT.mkdir(parents=True, exist_ok=True)
    start = time.monotonic()
    took = runs(program, OUT / "runs")
    ran = time.monotonic() - start
    decisions = copied()
    known = cases(program)
    navigation(known, decisions)
    verification(program, OUT / "runs", known)
    for name in OWN:
        pictures(name, OUT / "runs")
    gallery(OUT / "runs", known)
    schema = json.loads(subprocess.run([program, "schema"], capture_output=True, text=True, check=True).stdout)
    write("keys.md", Keys(schema).page())
    columns(program)
    commands(program)
    checked = written(OUT / "runs")
    slowest = ", ".join(f"{name} {took[name]:.1f} s" for name in sorted(took, key=took.get)[-3:])
    print(f"book: {len(took)} runs in {ran:.0f} s (longest: {slowest}), {checked} columns of tables are told of")


if __name__ == "__main__":
    try:
        main()
    except Fault as fault:
        sys.exit(f"book: {fault}")
