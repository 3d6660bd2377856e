"""The site: ``python docs/_site.py`` collects its pages in runs/site and makes site/ of them.

Zensical, which makes the site, runs no code of a project. Therefore its source is a folder: pages with their formulas
as drawings, generated pages, runs of the gallery, executed tutorials, and the pictures and configs to which pages lead.
A dead link, or an anchor that is not there, ends the build.
"""

import re
import shutil
import subprocess
import sys
from fnmatch import fnmatch
from pathlib import Path

import _command_line
import _files
import _formulas
import _gallery
import _reference
import _tutorials
from ruamel.yaml import YAML

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "runs" / "site"
SITE = ROOT / "site"
FOLDERS = {"media": ("*.png", "*.mp4", "*.gif"), "configs": ("*.yaml",)}
"""Folders beside docs/ that pages reach by ``../``, at the same names in the site."""
NOT_COPIED = ("_*", "gallery/*")
"""Files of docs/ that are no part of the site, or are made anew for it."""
NOTEBOOK = re.compile(r"(\]\([^)\s]*tutorials/[^)\s]+)\.ipynb\)")
"""Link to a notebook, as a clone has it; the site has it executed, as a page."""
SHIM = re.compile(r'src="https?://[^"]*/iframe-worker/shim"')
"""Script by which the search works from disk, as Zensical takes it from the network."""


def contents():
    """Return name in the site -> text, bytes, or the path of a file, and the names of generated pages by section."""
    docs, found = ROOT / "docs", {}
    for path in sorted(path for path in docs.rglob("*") if path.is_file()):
        name = path.relative_to(docs).as_posix()
        if not any(fnmatch(name, pattern) for pattern in NOT_COPIED) and "__pycache__" not in name:
            found[name] = path.read_text(encoding="utf-8") if path.suffix == ".md" else path
    for folder, patterns in FOLDERS.items():
        paths = [path for pattern in patterns for path in (ROOT / folder).glob(pattern)]
        found |= {f"{folder}/{path.name}": path for path in paths}
    # pages of a clone that say where to read instead
    found |= {name: page() for name, page in {**_reference.PAGES, **_command_line.PAGES, **_files.PAGES}.items()}
    generated = {"Tutorials": _tutorials.contents(), "Gallery": _gallery.contents()}
    sections = {title: [name for name in own if name.endswith(".md")] for title, own in generated.items()}
    return {**found, **generated["Tutorials"], **generated["Gallery"]}, sections


def in_site(name, text):
    """Return the Markdown of a page with links as they are in the site, in which docs/ is the root, and drawings."""
    up = "../" * name.count("/")
    for folder in FOLDERS:
        text = text.replace(f"]({up}../{folder}/", f"]({up}{folder}/")
    return _formulas.with_drawings(NOTEBOOK.sub(r"\1.md)", text))


def write_source():
    """Write pages and config of the site into ``SOURCE``."""
    shutil.rmtree(SOURCE, ignore_errors=True)
    found, sections = contents()
    for name, content in found.items():
        path = SOURCE / "docs" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if isinstance(content, Path):
            shutil.copyfile(content, path)
        elif isinstance(content, bytes):
            path.write_bytes(content)
        else:
            path.write_text(in_site(name, content), encoding="utf-8")
    yaml = YAML()
    config = yaml.load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    for place, (title, names) in enumerate(sections.items(), 3):
        config["nav"].insert(place, {title: names})
    (api,) = (plugin["mkdocstrings"] for plugin in config["plugins"] if "mkdocstrings" in plugin)
    api["handlers"]["python"]["paths"] = [str(ROOT)]
    with (SOURCE / "mkdocs.yml").open("w", encoding="utf-8") as file:
        yaml.dump(config, file)


def main():
    """Make the site; exit with the message of what is wrong."""
    try:
        write_source()
    except (_gallery.OutOfBoundsError, RuntimeError) as error:
        sys.exit(f"error: {error}")
    done = subprocess.run(
        [sys.executable, "-m", "zensical", "build", "--strict", "--clean"], cwd=SOURCE, capture_output=True, text=True
    )
    if done.returncode:
        sys.exit((done.stdout + done.stderr).partition("Traceback")[0].strip())
    shutil.rmtree(SITE, ignore_errors=True)
    shutil.move(SOURCE / "site", SITE)
    for page in SITE.rglob("*.html"):
        up = "../" * (len(page.relative_to(SITE).parts) - 1)
        text = page.read_text(encoding="utf-8")
        page.write_text(SHIM.sub(f'src="{up}assets/iframe-worker.js"', text), encoding="utf-8")
    print(f"{len(list(SITE.rglob('*.html')))} pages: {(SITE / 'index.html').relative_to(ROOT)}")


if __name__ == "__main__":
    main()
