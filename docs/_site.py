"""What the site needs besides the pages: the pictures and configs to which they link, and their formulas as drawings.

Formulas are drawn by matplotlib when the site is made: a reader needs no script and no network.
"""

import html
import io
import re
from pathlib import Path

from matplotlib import mathtext, rc_context
from matplotlib.font_manager import FontProperties
from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = {"media": ("*.png", "*.mp4"), "configs": ("*.yaml",)}

FORMULA = re.compile(r"^\$\$(.+?)\$\$$", flags=re.MULTILINE | re.DOTALL)


def on_files(files, config):
    """Add the files that pages reach by ``../media`` and ``../configs``, at the same names in the site."""
    for folder, patterns in FOLDERS.items():
        for path in sorted(path for pattern in patterns for path in (ROOT / folder).glob(pattern)):
            files.append(File.generated(config, f"{folder}/{path.name}", abs_src_path=str(path)))
    return files


def on_page_markdown(markdown, page, **_):
    """Links as they are in the site, in which docs/ is the root, and formulas as drawings."""
    up = "../" * page.file.src_uri.count("/")
    for folder in FOLDERS:
        markdown = markdown.replace(f"]({up}../{folder}/", f"]({up}{folder}/")
    return FORMULA.sub(lambda found: drawn(found.group(1).strip()), markdown)


def drawn(formula):
    """A formula as SVG in the colour of the text around it; ValueError for one that mathtext does not know."""
    stream = io.StringIO()
    with rc_context({"mathtext.fontset": "stix", "svg.fonttype": "path", "svg.hashsalt": "tisph"}):
        large = formula.replace(r"\frac", r"\dfrac")  # as in a line of its own
        large = re.sub(r"\s*\\tag\{(\w+)\}", r"\\qquad (\1)", large)
        mathtext.math_to_image(f"${large}$", stream, prop=FontProperties(size=13), format="svg")
    picture = stream.getvalue()
    picture = re.sub(r"<metadata>.*?</metadata>", "", picture[picture.index("<svg") :], flags=re.DOTALL)
    picture = re.sub(r'<g id="patch_1">.*?</g>', "", picture, count=1, flags=re.DOTALL)  # the white behind it
    label = (
        f'<svg role="img" aria-label="{html.escape(formula, quote=True)}" style="fill: currentColor; max-width: 100%" '
    )
    return f"<p>{' '.join(picture.split()).replace('<svg ', label, 1)}</p>"
