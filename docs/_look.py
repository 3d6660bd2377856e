"""Look at the finished site as readers do: from disk, in Chromium, on a phone and on a screen; nothing without it.

No page may be wider than its window, no picture missing, and the search must find "no-slip".
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "core"))

import browser

ROOT = Path(__file__).resolve().parents[1]
WIDTHS = 400, 1400
WITHIN = "document.documentElement.scrollWidth <= innerWidth"
PICTURES = "[...document.images].filter(one => one.complete && !one.naturalWidth).map(one => one.src)"
SEARCH = """new Promise(resolve => {
  document.querySelector('[data-md-toggle=search]').click();
  let tries = 0;
  const look = () => {
    const box = document.querySelector('[data-md-component=search-query]');
    box.focus(); box.value = 'no-slip'; box.dispatchEvent(new KeyboardEvent('keyup', {key: 'p'}));
    const found = document.querySelectorAll('.md-search-result__item').length;
    found || ++tries > 40 ? resolve(found) : setTimeout(look, 250);
  };
  look();
})"""


def main():
    """Exit with a message for the first pages that are wrong."""
    if browser.program() is None:
        print("no Chromium: nobody has looked at the site")
        return
    wrong = []
    with tempfile.TemporaryDirectory() as profile:
        window = browser.Browser(Path(profile))
        try:
            for page in sorted((ROOT / "site").rglob("*.html")):
                for width in WIDTHS:
                    window.open(page, width)
                    if not window.value(WITHIN):
                        wrong.append(f"{page.relative_to(ROOT)} is wider than {width} pixels")
                    wrong += [f"{page.relative_to(ROOT)}: no picture {source}" for source in window.value(PICTURES)]
            window.open(ROOT / "site" / "index.html", WIDTHS[1])
            if not window.value(SEARCH):
                wrong.append("the search does not find no-slip from disk")
        finally:
            window.close()
    sys.exit("\n".join(wrong) or None)


if __name__ == "__main__":
    main()
