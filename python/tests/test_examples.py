"""The notebook and the code in the README do what they say."""

import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def test_the_notebook_of_contrasts_runs():
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    notebook = json.loads((ROOT / "examples" / "contrast.ipynb").read_text(encoding="utf-8"))
    names = {"__name__": "notebook"}
    for number, cell in enumerate(notebook["cells"]):
        if cell["cell_type"] == "code":
            assert not cell["outputs"], "the notebook is kept without outputs"
            text = "".join(cell["source"])
            exec(compile(text, f"cell {number}", "exec"), names)
    assert names["growth"] < 10


def blocks(path):
    found = re.findall(r"```python\n(.*?)```", path.read_text(encoding="utf-8"), re.S)
    assert found
    return found


def test_the_code_of_the_readme_runs():
    pytest.importorskip("matplotlib").use("Agg")
    pytest.importorskip("pandas")
    names = {}
    for block in blocks(ROOT / "README.md"):
        # What only pyvista can show is tested elsewhere, and the crack need not grow here.
        block = re.sub(r"^.*to_pyvista\(\) +#.*$", "", block, flags=re.M)
        block = block.replace('smoke")', 'smoke").update({"time.end": "0.01 s"})')
        exec(compile(block, "README.md", "exec"), names)
    assert names["table"].column("status") == ["done", "done"]


def test_the_code_of_the_front_page_is_that_of_the_readme():
    ours = "".join(blocks(ROOT / "README.md"))
    for block in blocks(ROOT.parent / "README.md"):
        for line in block.splitlines():
            assert line.split("  #")[0].strip() in ours
