"""Formulas as drawings in the page: a reader needs no script, no font and no network.

matplotlib draws them when the site is made, as SVG in the size and the colour of the text around them.
"""

import html
import io
import re
import zlib
from functools import cache

from matplotlib import mathtext, rc_context
from matplotlib.font_manager import FontProperties

SIZE = 13  # points in which formulas are drawn
STYLE = {"mathtext.fontset": "stix", "svg.fonttype": "path", "svg.hashsalt": "tisph"}
CODE = re.compile(r"(^ *```.*?^ *```|``.+?``|`[^`\n]+`)", flags=re.MULTILINE | re.DOTALL)
DISPLAY = re.compile(r"\$\$(.+?)\$\$", flags=re.DOTALL)
INLINE = re.compile(r"(?<![\\$\w])\$(?=[^\s$])([^$\n]*(?:\n[^$\n]+)?[^\s$])\$(?![\w$])")
NUMBER = re.compile(r"\s*\\tag\{(\w+)\}")


def with_drawings(markdown):
    """The text of a page with its formulas, ``$...$`` and ``$$...$$``, as drawings; code stays as it is."""
    parts = CODE.split(markdown)
    parts[::2] = [INLINE.sub(_inline, DISPLAY.sub(_display, part)) for part in parts[::2]]
    return "".join(parts)


def _display(found):
    formula = " ".join(found.group(1).split())
    number = NUMBER.search(formula)
    picture = drawn(NUMBER.sub("", formula).replace(r"\frac", r"\dfrac"))  # as in a line of its own
    label = f"<span>({number.group(1)})</span>" if number else ""
    return f'<div class="formula">{picture}{label}</div>'


def _inline(found):
    return drawn(" ".join(found.group(1).split()))


@cache
def drawn(formula):
    """A formula as SVG; ValueError for one that mathtext does not know."""
    stream, text, font = io.StringIO(), f"${formula}$", FontProperties(size=SIZE)
    with rc_context(STYLE):
        mathtext.math_to_image(text, stream, prop=font, format="svg")
        width, _, depth, *_ = mathtext.MathTextParser("path").parse(text, dpi=72, prop=font)
    picture = re.sub(r"<!--.*?-->|<metadata>.*?</metadata>", "", stream.getvalue(), flags=re.DOTALL)
    picture = picture[picture.index("<svg") :]
    picture = re.sub(r'<g id="patch_1">.*?</g>', "", picture, count=1, flags=re.DOTALL)  # the white behind it
    picture = re.sub(r'(<svg [^>]*?)width="[^"]*"', r"\1", re.sub(r'(<svg [^>]*?)height="[^"]*"', r"\1", picture))
    picture = re.sub(r"<defs>\s*<style.*?</style>\s*</defs>", "", picture, flags=re.DOTALL)
    name = f"f{zlib.crc32(formula.encode()):x}"
    picture = re.sub(r'(id="|href="#|url\(#)', rf"\g<1>{name}-", picture)  # glyphs of one page share no names
    size = f"width: {width / SIZE:.3f}em; height: auto; vertical-align: {-depth / SIZE:.3f}em"
    label = f'<svg class="math" role="img" aria-label="{html.escape(formula, quote=True)}" style="{size}" '
    return " ".join(picture.split()).replace("<svg ", label, 1)
