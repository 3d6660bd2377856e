"""``tisph report``: what is on the page, and what a real browser makes of it."""

import base64
import io
import json
import re
import shutil
from dataclasses import replace
from html.parser import HTMLParser

import browser
import imageio_ffmpeg
import numpy as np
import pytest
from couette import couette_text
from PIL import Image
from typer.testing import CliRunner

import tisph
from tisph import cli
from tisph.report.labels import scientific
from tisph.results.page import View, estimate_table, measure_table, movie_element, report

pytestmark = pytest.mark.taichi

OUTPUT = {"video": {"frames": 10, "width": 640, "height": 320}}
CASE = couette_text(time={"end": 1.0, "samples": [0.4, 1.0]}, output=OUTPUT)

HOSTILE = "</title><script>alert(1)</script><img src=x onerror=alert(2)>&amp;\"'"
WIDTHS = (400, 1600)


WIDER = """[...document.querySelectorAll('body *')].filter(part => !part.closest('.wide') &&
    part.getBoundingClientRect().right > document.documentElement.clientWidth + 0.5).map(part => part.outerHTML)"""


class Structure(HTMLParser):
    """What a page has: ``tags`` with their attributes, and its ``words``."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.words = [], ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))

    def handle_data(self, data):
        self.words += data


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder of a finished run."""
    folder = tmp_path_factory.mktemp("page")
    (folder / "small.yaml").write_text(CASE)
    done = CliRunner().invoke(cli.app, ["run", str(folder / "small.yaml"), "--out", str(folder / "small")])
    assert done.exit_code == 0, done.stderr
    return folder / "small"


@pytest.fixture(scope="module")
def other(folder):
    """Folder of the same run as one with another name and seed, which diverged with a hostile message."""
    copy = shutil.copytree(folder, folder.parent / HOSTILE.replace("/", "_"))
    text = (copy / "config.resolved.yaml").read_text()
    (copy / "config.resolved.yaml").write_text(text.replace("seed: 0", "seed: 7").replace("name: small", "name: other"))
    summary = json.loads((copy / "summary.json").read_text())
    (copy / "summary.json").write_text(
        json.dumps({**summary, "name": HOSTILE, "status": "diverged", "message": HOSTILE})
    )
    return copy


@pytest.fixture(scope="module")
def page(folder, other):
    """Path of the page of both."""
    path = folder.parent / "both.html"
    done = CliRunner().invoke(cli.app, ["report", str(folder), str(other), "--out", str(path)])
    assert (done.exit_code, done.stdout.strip()) == (0, str(path)), done.stderr
    return path


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    """A browser."""
    if browser.program() is None:
        pytest.skip("there is no Chromium on this system: apt-get install chromium")
    page = browser.Browser(tmp_path_factory.mktemp("profile"))
    yield page
    page.close()


def test_the_page_needs_nothing_but_itself(page):
    found = Structure(page.read_text())
    assert not [tag for tag, _ in found.tags if tag in ("script", "iframe", "object", "form")]
    addresses = [value for _, has in found.tags for key, value in has.items() if key in ("src", "href", "poster")]
    assert all(address.startswith(("data:", "#")) for address in addresses)
    assert not [key for _, has in found.tags for key in has if key.startswith("on")]
    assert "http" not in re.sub('data:[^"]*|http-equiv', "", page.read_text())


def test_the_still_of_a_movie_is_its_last_frame(folder):
    (has,) = (has for tag, has in Structure(report([tisph.open(folder)])).tags if tag == "video")
    still = Image.open(io.BytesIO(base64.b64decode(has["poster"].removeprefix("data:image/jpeg;base64,"))))
    _, *frames = imageio_ffmpeg.read_frames(str(folder / "movie.mp4"))
    differences = [
        np.abs(np.asarray(still, float) - np.frombuffer(each, np.uint8).reshape(320, 640, 3)) for each in frames
    ]
    assert int(np.argmin([each.mean() for each in differences])) == 9
    assert differences[9].mean() < 3.0  # levels of 255, of JPEG


def test_a_movie_that_cannot_be_read_has_no_still(tmp_path):
    (tmp_path / "movie.mp4").write_bytes(b"nothing")
    assert 'poster="' not in movie_element(tmp_path / "movie.mp4", "damaged")


def test_hostile_text_is_text(page, other):
    found = Structure(page.read_text())
    assert found.words.count(f"diverged: {HOSTILE}") == 1
    assert f"small, {HOSTILE} - tisph" in found.words  # the title
    assert str(other) in found.words
    assert HOSTILE not in page.read_text()


def test_numbers_stand_beside_the_exact_ones(folder):
    run = tisph.open(folder)
    rows = {tuple(row.cells[:2]): row.cells[2:] for row in measure_table([run], [View.of(run, "small")]).rows}
    last = run.summary.samples[-1]
    value, exact, difference = rows["1 s", "wall shear top"]
    assert float(value) == pytest.approx(last["wall_shear_top"], rel=5e-6)  # six digits
    assert float(exact) == pytest.approx(last["wall_shear_top_exact"], rel=5e-6)
    assert difference == scientific(last["wall_shear_top"] - last["wall_shear_top_exact"])
    assert rows["1 s", "density variation"][1:] == ["–", "–"]


def test_estimated_errors_are_a_table_where_there_are_any(folder):
    run = tisph.open(folder)
    assert estimate_table([run], [View.of(run, "small")]).rows == []
    found = {"error": 1.31e-4, "order": 3.9, "reason": None}
    unknown = {"drag": {**found, "error": None, "reason": "why"}}
    samples = [{"t": 1.0, "fields": {"velocity": found}, "numbers": unknown}]
    run.summary = replace(run.summary, error_estimate={"reason": None, "samples": samples})
    assert [row.cells for row in estimate_table([run], [View.of(run, "small")]).rows] == [
        ["1 s", "velocity", "1.3×10⁻⁴", "3.9", "relative, L2"],
        ["1 s", "drag", "–", "3.9", "why"],
    ]


def test_a_run_that_left_little_has_a_page_too(folder, tmp_path):
    (tmp_path / "config.resolved.yaml").write_text((folder / "config.resolved.yaml").read_text())
    found = Structure(report([tisph.open(tmp_path)]))
    assert "failed" in found.words
    assert not [tag for tag, _ in found.tags if tag in ("img", "video")]


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_a_browser_shows_it_without_a_complaint_and_within_its_window(chromium, page, width, dark):
    chromium.open(page, width, dark)
    assert chromium.said == []
    assert chromium.value("document.documentElement.scrollWidth <= innerWidth")
    assert chromium.value(WIDER) == []
    pictures = "[...document.images].every(picture => picture.complete && picture.naturalWidth > 0)"
    assert chromium.value(pictures)
    colour = chromium.value("getComputedStyle(document.body).backgroundColor")
    assert (colour == "rgb(255, 255, 255)") != dark


def test_a_browser_takes_hostile_text_for_text_and_prints(chromium, page):
    chromium.open(page, WIDTHS[0])
    assert chromium.value("document.title") == f"small, {HOSTILE} - tisph"
    assert chromium.value("document.querySelectorAll('script, [onerror]').length") == 0
    assert chromium.said == []  # no dialogue, no request
    assert chromium.printed().startswith(b"%PDF")
