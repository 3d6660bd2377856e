"""Look at the finished site as readers do: from disk, in Chromium, on a phone and on a screen; nothing without it.

No page may be wider than its window, no picture missing, and the search must find "no-slip". In a draft pages of the
gallery without a run of their own are left out, and one page of each folder is shown on a screen.
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))

import browser
from _gallery import DRAFT, DRAFT_RUNS

ROOT = Path(__file__).resolve().parents[1]
WIDTHS = 400, 1400
WITHIN = "document.documentElement.scrollWidth <= innerWidth"
PICTURES = "[...document.images].filter(one => one.complete && !one.naturalWidth).map(one => one.src)"
FOUND = """new Promise(resolve => {
  let tries = 0;
  const look = () => {
    const roots = [...document.querySelectorAll('div')].map(one => one.shadowRoot).filter(root => root);
    const found = roots.some(root => /[1-9]\\d* results/.test(root.textContent));
    found || ++tries > 40 ? resolve(found) : setTimeout(look, 250);
  };
  look();
})"""


def views():
    """Return pages, each with the widths of the windows in which it is shown."""
    pages = sorted((ROOT / "site").rglob("*.html"))
    if not DRAFT:
        return [(page, WIDTHS) for page in pages]
    pages = [page for page in pages if page.parent.name != "gallery" or page.stem in ("index", *DRAFT_RUNS)]
    first = {page.parent: page for page in reversed(pages)}
    return [(page, WIDTHS if first[page.parent] == page else WIDTHS[:1]) for page in pages]


def main():
    """Exit with a message for the first pages that are wrong."""
    if browser.program() is None:
        print("no Chromium: nobody has looked at the site")
        return
    wrong = []
    with tempfile.TemporaryDirectory() as profile:
        window = browser.Browser(Path(profile))
        try:
            shown = views()
            for number, (page, widths) in enumerate(shown, 1):
                for width in widths:
                    window.open(page, width)
                    if not window.value(WITHIN):
                        wrong.append(f"{page.relative_to(ROOT)} is wider than {width} pixels")
                    wrong += [f"{page.relative_to(ROOT)}: no picture {source}" for source in window.value(PICTURES)]
                if number % 10 == 0 or number == len(shown):
                    print(f"looked at {number} of {len(shown)} pages", flush=True)
            window.open(ROOT / "site" / "index.html", WIDTHS[1])
            window.value("document.querySelector('.md-search__button').click()")
            window.type("no-slip")
            if not window.value(FOUND):
                wrong.append("the search does not find no-slip from disk")
        finally:
            window.close()
    sys.exit("\n".join(wrong) or None)


if __name__ == "__main__":
    main()
