"""What the site needs besides the pages: pictures and configs to which they link, drawn formulas, generated pages."""

import re
import sys
from pathlib import Path

from mkdocs.structure.files import File

sys.path.insert(0, str(Path(__file__).parent))

import _command_line
import _files
import _formulas
import _gallery
import _reference
import _tutorials

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = {"media": ("*.png", "*.mp4", "*.gif"), "configs": ("*.yaml",)}
NOTEBOOK = re.compile(r"(\]\([^)\s]*tutorials/[^)\s]+)\.ipynb\)")
"""Link to a notebook, as a clone has it; the site has it executed, as a page."""


def on_files(files, config):
    """Add the files that pages reach by ``../media`` and ``../configs``, at the same names in the site."""
    for folder, patterns in FOLDERS.items():
        for path in sorted(path for pattern in patterns for path in (ROOT / folder).glob(pattern)):
            files.append(File.generated(config, f"{folder}/{path.name}", abs_src_path=str(path)))
    for name, page in {**_reference.PAGES, **_command_line.PAGES, **_files.PAGES}.items():
        files.remove(files.get_file_from_path(name))  # the page of a clone, which says where to read instead
        files.append(File.generated(config, name, content=page()))
    return _tutorials.add(_gallery.add(files, config), config)


def on_page_markdown(markdown, page, **_):
    """Links as they are in the site, in which docs/ is the root, and formulas as drawings."""
    up = "../" * page.file.src_uri.count("/")
    for folder in FOLDERS:
        markdown = markdown.replace(f"]({up}../{folder}/", f"]({up}{folder}/")
    markdown = NOTEBOOK.sub(r"\1.md)", markdown)
    return _formulas.with_drawings(markdown)


def on_post_page(output, page, **_):
    """The worker that the search needs without a server, from this site instead of the network."""
    up = "../" * page.file.src_uri.count("/")
    return re.sub(r'src="https?://[^"]*/iframe-worker/shim"', f'src="{up}assets/iframe-worker.js"', output)
