"""Tutorials: the notebooks of docs/tutorials/, executed when the site is made, as pages.

``make docs`` calls ``contents``. A notebook whose code fails ends the build. Two notebooks are executed at once.
Executed notebooks are kept in runs/tutorials/ and used again as long as notebook and package are the same. They become
Markdown here, since the site draws formulas of Markdown without a script; nbconvert brings a page, styles and a script
of its own.
"""

import base64
import hashlib
import os
import re

import nbformat
from _gallery import ROOT, in_turn, package

NOTEBOOKS = ROOT / "docs" / "tutorials"
RUNS = ROOT / "runs" / "tutorials"
NOTICE = re.compile(r"\[I .*shell\.py")
"""A line that Taichi prints in notebooks."""


def executed(path):
    """Return the notebook with its outputs; nbclient.exceptions.CellExecutionError where its code fails."""
    import nbclient

    folder = RUNS / path.stem
    done, stamp = folder / "executed.ipynb", folder / "stamp"
    key = hashlib.sha256(path.read_bytes() + package().encode()).hexdigest()
    if not (stamp.is_file() and stamp.read_text() == key):
        folder.mkdir(parents=True, exist_ok=True)
        os.environ["PYTHONPATH"] = str(ROOT)  # the kernel is a process of its own
        notebook = nbformat.read(path, as_version=4)
        nbclient.NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(folder)}}).execute()
        nbformat.write(notebook, done)
        stamp.write_text(key)
    return nbformat.read(done, as_version=4)


def markdown(notebook, name):
    """Return a page, and the pictures in it by file name."""
    parts, pictures = [], {}
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
            continue
        parts.append(f"```python\n{cell.source}\n```")
        printed = "".join(output.text for output in cell.outputs if output.get("name") == "stdout")
        lines = [line for line in printed.splitlines() if line and not NOTICE.match(line)]
        parts.append("```text\n" + "\n".join(lines) + "\n```" if lines else "")
        parts += [_shown(output, name, pictures) for output in cell.outputs if output.output_type != "stream"]
    parts.append(f"[This page as a notebook]({name}.ipynb)")
    return "\n\n".join(part for part in parts if part) + "\n", pictures


def _shown(output, name, pictures):
    data = output.get("data", {})
    if "image/png" in data:
        picture = f"{name}-{len(pictures)}.png"
        pictures[picture] = base64.b64decode(data["image/png"])
        return f"![Plot made by the code above]({picture})"
    if "text/html" in data:
        return f"<div>\n{' '.join(data['text/html'].split())}\n</div>"
    return f"```text\n{data['text/plain']}\n```" if "text/plain" in data else ""


def contents():
    """Return name in the site -> text, bytes, or path of a page for each notebook, with its pictures.

    Raises RuntimeError where the code of a notebook fails.
    """
    from nbclient.exceptions import CellExecutionError

    def page(path):
        try:
            return markdown(executed(path), path.stem)
        except CellExecutionError as error:
            raise RuntimeError(f"tutorial {path.name}: {error}") from error

    found, paths = {}, sorted(NOTEBOOKS.glob("*.ipynb"))
    for path, (text, pictures) in zip(paths, in_turn(page, paths, "tutorials: notebook"), strict=True):
        found[f"tutorials/{path.stem}.md"] = text
        found |= {f"tutorials/{name}": content for name, content in pictures.items()}
    return found
