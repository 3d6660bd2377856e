"""The gallery: one page a flow, made from docs/_gallery/NAME.yaml and from runs that are made for it.

``make docs`` calls ``contents``. Each file says which config is run, with what settings, the text of its page, and the
numbers in it. A number that is not within its bound ends the build, with the names of the page and of the number. Runs
are kept in runs/gallery/ and used again as long as config, settings and package are the same.
``python docs/_gallery.py NAME...`` makes the runs of some pages, or of all, prints their numbers, and leaves their
panels and the index in docs/gallery/, which a clone shows without a site.

``make docs-draft`` (GALLERY=draft) makes the beginning of ``DRAFT_RUNS`` alone. The other pages show the pictures of
the first of them, and no page has numbers: the site is built and looked at as a whole in a few minutes.

``equals`` is a number, a key of the run, or a name of the table of references (``dfg_2d_1.drag_coefficient``).
In a text, <<name>> stands for the number of that name; a key may be a sum, ``samples.1.drag + samples.1.drag_top``.
"""

import hashlib
import io
import itertools
import json
import math
import os
import re
import shlex
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import imageio_ffmpeg
from PIL import Image, ImageOps
from ruamel.yaml import YAML

from tisph.references import table as references

ROOT = Path(__file__).resolve().parents[1]
TEXTS = ROOT / "docs" / "_gallery"
PANELS = ROOT / "docs" / "gallery"
DRAFT = os.environ.get("GALLERY") == "draft"
RUNS = ROOT / "runs" / ("gallery-draft" if DRAFT else "gallery")
DRAFT_RUNS = "couette", "cylinder_in_channel", "taylor_vortices"
DRAFT_PART = 0.002
"""Part of the duration of a run that a draft simulates."""
MOVIE = [
    "output.video.style=field",
    "output.video.width=960",
    "output.video.height=480",
    "output.video.frames=60",
    "output.video.fps=15",
]
NO_MOVIE = ["output.video.frames=2"]
AT_ONCE = 2
ACROSS = 3
"""Panels in a row of the index."""
TILE = (360, 240)
"""Pixels of a panel."""
MIDDLE = 0.5
"""Part of a movie at which its panel is taken, where the page has no ``still``."""


class OutOfBoundsError(Exception):
    """Numbers of the gallery that are not what their page says."""


@dataclass(frozen=True)
class Job:
    """A run of the gallery: its folder below runs/gallery, its config, and what is set."""

    name: str
    config: Path
    settings: tuple[str, ...]

    @property
    def folder(self):
        """Return where the results are; in a draft, of a page without a run, the results of the first page."""
        return RUNS / (DRAFT_RUNS[0] if DRAFT and self.name not in DRAFT_RUNS else self.name)

    def stamp(self):
        """Return a hash of all on which the results depend."""
        text = json.dumps([self.config.read_text(encoding="utf-8"), self.settings, package()])
        return hashlib.sha256(text.encode()).hexdigest()

    def command(self, settings):
        """Return the arguments of tisph."""
        sets = [word for text in settings for word in ("--set", text)]
        return ["run", self.config.relative_to(ROOT).as_posix(), *sets]

    def line(self):
        """Return the command that a reader pastes into a shell: into a folder of its own, its movie in full size."""
        settings = [text for text in self.settings if text not in (*MOVIE, *NO_MOVIE)]
        return shlex.join(["tisph", *self.command(settings), "--out", f"runs/try/{self.name}"])

    def make(self):
        """Run it, unless its results are there; RuntimeError with the last lines of what it printed if that fails."""
        stamp = self.folder / "gallery.stamp"
        if stamp.is_file() and stamp.read_text() == self.stamp():
            return
        stamp.unlink(missing_ok=True)
        extra = ["--set", "runtime.threads=1", "--out", str(self.folder), "--overwrite"]
        extra += self.cut_short() if DRAFT else []
        environment = dict(os.environ, OMP_NUM_THREADS="1", PYTHONPATH=str(ROOT))
        done = subprocess.run(
            [sys.executable, "-m", "tisph", *self.command(self.settings), *extra],
            cwd=ROOT,
            env=environment,
            capture_output=True,
            text=True,
        )
        if done.returncode:
            raise RuntimeError(f"gallery: the run {self.name} failed:\n{(done.stdout + done.stderr)[-2000:]}")
        stamp.write_text(self.stamp())

    def cut_short(self):
        """Return arguments that let a run end after ``DRAFT_PART`` of its duration, with as many samples."""
        from tisph.config import load

        config = load(self.config, self.settings)
        start = config.start_time
        samples = [float(f"{start + DRAFT_PART * (t - start):.6g}") for t in config.time.samples]
        words = [f"time.samples={json.dumps(samples)}", f"time.end={samples[-1]}", "output.video.frames=2"]
        return [word for text in words for word in ("--set", text)]

    def summary(self):
        """Return what summary.json says."""
        return json.loads((self.folder / "summary.json").read_text(encoding="utf-8"))


@cache
def package():
    """Return a hash of the package's source."""
    paths = sorted(path for path in (ROOT / "tisph").rglob("*") if path.suffix in (".py", ".html", ".css", ".yaml"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in paths)).hexdigest()


def flows():
    """Return what docs/_gallery/ says of each page, by name, in the order of their numbers."""
    found = {path.stem: YAML(typ="safe").load(path.read_text(encoding="utf-8")) for path in TEXTS.glob("*.yaml")}
    return dict(sorted(found.items(), key=lambda item: (item[1]["order"], item[0])))


def jobs(name, flow):
    """Return the run of a page, and those of its exercises."""
    config = ROOT / "configs" / f"{flow['config']}.yaml"
    settings = flow.get("settings", [])
    own = Job(name, config, (*settings, *MOVIE, *flow.get("movie", [])))
    exercises = (
        Job(f"{name}-{number}", config, (*settings, *exercise["settings"], *NO_MOVIE))
        for number, exercise in enumerate(flow["try"], 1)
    )
    return [own, *exercises]


def value(summary, key):
    """Return the number of a dotted key, in which a number counts list entries, ``samples.-1.l2``, or of a sum."""
    if DRAFT:
        return math.nan
    return sum(_entry(summary, term) for term in key.split(" + "))


def _entry(summary, key):
    for part in key.split("."):
        summary = summary[int(part)] if isinstance(summary, list) else summary[part]
    return float(summary)


def bound(summary, check):
    """Return the reference of a check, by which it is bounded, and whether the number keeps within its bound."""
    number = value(summary, check["key"])
    if "below" in check:
        return float(check["below"]), abs(number) < check["below"]
    reference = check["equals"]
    if isinstance(reference, str):
        known = reference.partition(".")[0] in references.flows()
        reference = references.number(reference) if known else value(summary, reference)
    reference = float(reference)
    return reference, abs(number - reference) <= check["within"] * abs(reference)


def failures(name, summary, checks):
    """Return a line for each number that is out of its bound."""
    lines = []
    for check in checks:
        reference, kept = bound(summary, check)
        if not kept:
            wanted = f"below {reference:g}" if "below" in check else f"{reference:g} within {check['within']:g}"
            found = value(summary, check["key"])
            lines.append(f"gallery page {name}: {check['name']} ({check['key']}) is {found:g}, not {wanted}")
    return lines


def shown(number):
    """Return a number in four digits, or in two with a power of ten if it is small."""
    if 0 < abs(number) < 1e-3:
        return f"{number:.1e}".replace("e-0", "e-")
    return f"{number:.4g}"


def filled(text, summary, checks):
    """Return the text with the numbers in the places of their names; KeyError for a name that no check has."""
    numbers = {check["name"]: shown(value(summary, check["key"])) for check in checks}
    return re.sub(r"<<(\w+)>>", lambda found: numbers[found.group(1)], text).strip()


def table(summary, checks):
    """Return the numbers of a page beside their references, as a table."""
    lines = ["| | run | reference |", "|:--|--:|--:|"]
    for check in checks:
        reference, _ = bound(summary, check)
        wanted = f"below {shown(reference)}" if "below" in check else shown(reference)
        lines.append(f"| {check['says']} | {shown(value(summary, check['key']))} | {wanted} |")
    return "\n".join(lines)


def page(name, flow):
    """Return a page as Markdown."""
    own, *exercises = jobs(name, flow)
    summary = own.summary()
    chosen = [text.split("=")[0] for text in flow.get("movie", [])]
    smaller = [text for text in MOVIE if text.split("=")[0] not in chosen]
    parts = [
        f"# {flow['title']}",
        filled(flow["question"], summary, flow["numbers"]),
        video(name, flow["alt"]),
        filled(flow["story"], summary, flow["numbers"]),
        f"## Numbers\n\n{table(summary, flow['numbers'])}",
        filled(flow.get("remark", ""), summary, flow["numbers"]),
        unresolved(summary),
        f"![{flow['plot_alt']}]({name}-{flow.get('plot', 'profiles')}.png)",
        f"## Try this\n\n{exercise_texts(flow, exercises)}",
        f"## Config\n\n```\n{own.line()}\n```",
        f"The movie on this page is smaller (`{'`, `'.join(smaller)}`).",
        f"```yaml\n{own.config.read_text(encoding='utf-8').strip()}\n```",
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def unresolved(summary):
    """Return which samples the run itself calls unresolved, and why; empty where it does not."""
    reasons = [f"t = {sample['t']:g}: {sample['reason']}" for sample in summary["samples"] if not sample["resolved"]]
    return "Not resolved, as the run says: " + "; ".join(reasons) + "." if reasons else ""


def video(name, alt):
    """Return the movie, with a still of it for where it does not play."""
    attributes = f'controls loop muted playsinline preload="metadata" poster="{name}.jpg" aria-label="{alt}"'
    source = f'<source src="{name}.mp4" type="video/mp4">'
    return f'<video {attributes} style="width: 100%; height: auto">{source}{alt}</video>'


def exercise_texts(flow, exercises):
    """Return the exercises, each with its answer, which is folded away."""
    texts = []
    for number, (exercise, job) in enumerate(zip(flow["try"], exercises, strict=True), 1):
        answer = filled(exercise["answer"], {} if DRAFT else job.summary(), exercise["numbers"])
        hidden = f"<details markdown><summary>Answer</summary>\n\n```\n{job.line()}\n```\n\n{answer}\n\n</details>"
        texts.append(f"**{number}.** {exercise['question'].strip()}\n\n{hidden}")
    return "\n\n".join(texts)


def index(links, said):
    """Return the first page of the gallery: panels of all flows, three a row, with their titles; ``links`` by name."""
    head = "# Gallery\n\nOne page a flow: why one looks at it, a movie, numbers beside the reference, two exercises."
    tiles = {name: f"![]({name}-panel.jpg)<br>{flow['title']}" for name, flow in flows().items()}  # the title says it
    cells = [f"[{tile}]({links[name]})" for name, tile in tiles.items()]
    rows = [cells[first : first + ACROSS] for first in range(0, len(cells), ACROSS)]
    rows[-1] += [""] * (ACROSS - len(rows[-1]))
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    lines.insert(1, "|:-:" * ACROSS + "|")
    return "\n\n".join([head, said, "\n".join(lines)]) + "\n"


def clone_index():
    """Return docs/gallery/index.md: panels lead to configs, since ``make docs`` makes the pages."""
    links = {name: f"../../configs/{flow['config']}.yaml" for name, flow in flows().items()}
    return index(links, "`make docs` makes the pages, in `site/gallery/`. Here each picture leads to its config.")


def stills(path, parts):
    """Return frames of a movie, each at a part of its length."""
    film = imageio_ffmpeg.read_frames(str(path))
    size = next(film)["size"]
    frames = list(film)
    return [Image.frombytes("RGB", size, frames[round(part * (len(frames) - 1))]) for part in parts]


def panel(folder, part):
    """Return the flow without labels and curves, at a part of the movie of a run, as JPEG on a tile of ``TILE``."""
    from tisph.config import load
    from tisph.report.layout import arrange
    from tisph.report.movie import displayed
    from tisph.scenes import of

    (frame,) = stills(folder / "movie.mp4", [part])
    scene = of(load(folder / "config.resolved.yaml"))
    layout = arrange(displayed(scene), *frame.size)
    box, wall = layout.box, layout.wall_thickness
    flow = frame.crop((box.left, box.top - wall, box.right, box.bottom + wall))
    tile, content = Image.new("RGB", TILE, "white"), io.BytesIO()
    flow = ImageOps.contain(flow, TILE, Image.Resampling.LANCZOS)
    tile.paste(flow, ((TILE[0] - flow.width) // 2, (TILE[1] - flow.height) // 2))
    tile.save(content, format="JPEG", quality=85)
    return content.getvalue()


def in_turn(work, items, label):
    """Return ``work`` of all items, done ``AT_ONCE`` at a time; each prints a line when it is done."""
    start, number = time.perf_counter(), itertools.count(1)

    def noted(item):
        begin = time.perf_counter()
        result = work(item)
        now = time.perf_counter()
        took = f"{now - begin:.0f} s, {(now - start) / 60:.1f} min in all"
        print(f"{label} {next(number)} of {len(items)}: {getattr(item, 'name', item)} ({took})\n", end="", flush=True)
        return result

    with ThreadPoolExecutor(AT_ONCE) as pool:
        return list(pool.map(noted, items))


def make(names=()):
    """Make the runs of some pages, or of all, and check their numbers; OutOfBoundsError lists those out of bounds."""
    chosen = {name: flow for name, flow in flows().items() if not names or name in names}
    wanted = [job for name, flow in chosen.items() for job in jobs(name, flow)]
    wanted = [job for job in wanted if job.name in DRAFT_RUNS or not DRAFT]
    in_turn(Job.make, wanted, "gallery: run")
    if DRAFT:
        return chosen
    lines = []
    for name, flow in chosen.items():
        wanted = [flow["numbers"], *(exercise["numbers"] for exercise in flow["try"])]
        for job, checks in zip(jobs(name, flow), wanted, strict=True):
            lines += failures(job.name, job.summary(), checks)
    if lines:
        raise OutOfBoundsError("\n".join(lines))
    return chosen


def contents():
    """Return name in the site -> text, bytes, or path of the pages of the gallery, their movies and pictures.

    Raises OutOfBoundsError, and RuntimeError where a run fails.
    """
    from tisph.report.encoder import poster

    chosen = make()
    said = "All runs are made with this site, and the site is not made if a number leaves its bound."
    found = {"gallery/index.md": index({name: f"{name}.md" for name in chosen}, said)}
    found |= {f"gallery/{name}.md": page(name, flow) for name, flow in chosen.items()}
    for name, flow in chosen.items():
        folder, plot = jobs(name, flow)[0].folder, flow.get("plot", "profiles")
        found[f"gallery/{name}.mp4"] = folder / "movie.mp4"
        found[f"gallery/{name}-{plot}.png"] = folder / f"{plot}.png"
        found[f"gallery/{name}.jpg"] = poster(folder / "movie.mp4")
        found[f"gallery/{name}-panel.jpg"] = panel(folder, flow.get("still", MIDDLE))
    return found


if __name__ == "__main__":
    for page_name, what in make(sys.argv[1:]).items():
        results = jobs(page_name, what)[0]
        print(f"{page_name}\n{table(results.summary(), what['numbers'])}\n")
        (PANELS / f"{page_name}-panel.jpg").write_bytes(panel(results.folder, what.get("still", MIDDLE)))
    (PANELS / "index.md").write_text(clone_index(), encoding="utf-8")
