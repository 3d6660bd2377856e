"""The process that draws: the same pictures, one error for what fails, and an end with the process that started it."""

import io
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image
from report_scene import END, VIDEO, make_channel, make_snapshot

from tisph import scenes
from tisph.config import load
from tisph.errors import TisphError
from tisph.report import drawing_process
from tisph.report.drawing_process import DrawingProcess, RemoteMovie, described
from tisph.report.movie import Movie

TIMES = (1.0, 2.0, 5.0)


@pytest.fixture(scope="module")
def drawing():
    """A process for all of these tests, but those that end it."""
    one = DrawingProcess()
    yield one
    one._process.kill()


@pytest.fixture
def channel():
    return make_channel()


def frame_count(path):
    reader = imageio_ffmpeg.read_frames(str(path))
    next(reader)
    return sum(1 for _ in reader)


def test_a_picture_is_the_one_that_is_drawn_here(drawing, channel):
    snapshot = make_snapshot(channel, 1.0)
    image = drawing.request("still", *described(channel, VIDEO), "test", END, snapshot).result()
    here = Movie("unused.mp4", channel, VIDEO, "test", END).frame(snapshot)
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(image))), here)


def test_scenes_of_all_configs_can_be_sent_to_the_process():
    """Also with references and profiles that keep values which they have computed."""
    for config in sorted((Path(__file__).parents[2] / "configs").glob("*.yaml")):
        settings = load(config)
        assert pickle.dumps(described(scenes.of(settings), settings.output.video or VIDEO)), config.stem


def test_a_failed_movie_is_reported_once_when_it_is_closed(drawing, channel, tmp_path):
    movie = RemoteMovie(drawing, tmp_path / "no_such_folder" / "movie.mp4", channel, VIDEO, "test", END)
    for _ in range(20):
        movie.add(make_snapshot(channel, 1.0))
    with pytest.raises(TisphError, match="No such file or directory"):
        movie.close()
    movie.close()
    assert drawing.works


def test_an_error_in_drawing_has_a_name_and_ends_nothing(drawing, channel):
    with pytest.raises(TisphError, match=r"plots: \w+Error: "):
        drawing.request("plots", channel, {"profiles": ([None],)}).result()
    assert drawing.request("plots", channel, {"profiles": ([make_snapshot(channel, 1.0)],)}).result()


def test_a_process_that_has_gone_is_one_error_and_is_replaced(channel, tmp_path, monkeypatch):
    monkeypatch.setattr(drawing_process, "BACKLOG", 1)  # every task waits for the one before it
    monkeypatch.setattr(drawing_process, "_shared", None)
    gone = drawing_process.shared()
    assert drawing_process.shared() is gone
    gone._process.kill()
    movie = RemoteMovie(gone, tmp_path / "movie.mp4", channel, VIDEO, "test", END)
    for t in TIMES:
        movie.add(make_snapshot(channel, t))
    with pytest.raises(TisphError, match="the process that draws has ended"):
        movie.close()
    assert not gone.works
    gone._process.wait()
    other = drawing_process.shared()
    assert other is not gone
    other._process.kill()


@pytest.mark.skipif(os.name == "nt", reason="sends signals")
def test_the_run_waits_for_a_process_that_is_far_behind(monkeypatch):
    monkeypatch.setattr(drawing_process, "BACKLOG", 2)
    slow = DrawingProcess()
    slow.request("close").result()  # it has started
    os.kill(slow._process.pid, signal.SIGSTOP)
    sent, frame = [], bytes(2**20)  # more than a pipe holds, and there is no movie to draw it for
    sender = threading.Thread(target=lambda: sent.extend(slow.request("frame", frame) for _ in range(6)))
    sender.start()
    sender.join(0.5)
    assert sender.is_alive()
    os.kill(slow._process.pid, signal.SIGCONT)
    sender.join()
    assert [each.result(timeout=60) for each in sent] == [None] * 6
    slow._process.kill()


SCRIPT = """
import multiprocessing, sys
print("script")
from report_scene import make_channel, make_snapshot
from tisph.report.drawing_process import DrawingProcess
def drawn():
    channel = make_channel()
    return DrawingProcess().request("plots", channel, {"profiles": ([make_snapshot(channel, 1.0)],)}).result()
print(*drawn())
with multiprocessing.get_context("fork").Pool(1) as pool:
    print(*pool.apply(drawn))
"""


@pytest.mark.skipif(os.name == "nt", reason="forks")
def test_a_script_without_a_main_guard_can_draw(tmp_path):
    """It is not run a second time; nor are processes refused that are workers of ``multiprocessing.Pool``."""
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, script], env=environment, capture_output=True, text=True)
    assert done.stdout.splitlines() == ["script", "profiles", "profiles"], done.stderr


PARENT = """
import os, sys, time
from pathlib import Path
sys.path[:0] = sys.argv[2:]
from report_scene import END, VIDEO, make_channel, make_snapshot
from tisph.report.drawing_process import DrawingProcess, RemoteMovie
channel, process = make_channel(), DrawingProcess()
movie = RemoteMovie(process, Path(sys.argv[1]), channel, VIDEO, "test", END)
for t in (1.0, 2.0, 5.0):
    movie.add(make_snapshot(channel, t))
process.request("plots", channel, {"profiles": ([make_snapshot(channel, 1.0)],)}).result()  # so the frames are drawn
print(process._process.pid, flush=True)
time.sleep(60)
"""


@pytest.mark.skipif(os.name == "nt", reason="sends signals")
def test_it_ends_with_the_process_that_started_it_and_finishes_the_movie(tmp_path):
    path = tmp_path / "movie.mp4"
    command = [sys.executable, "-c", PARENT, path, *sys.path]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as parent:
        pid = int(parent.stdout.readline())
        parent.kill()
    while runs(pid):
        time.sleep(0.01)
    assert frame_count(path) == 3


def runs(pid):
    """Whether a process is there and has not ended (one that nobody waits for stays in the list)."""
    try:
        os.kill(pid, 0)
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except (ProcessLookupError, FileNotFoundError):
        return False


def test_it_imports_no_taichi_and_starting_it_no_matplotlib():
    for module, others in (
        ("drawing_process", ("taichi", "matplotlib")),
        ("drawing_worker", ("taichi", "pydantic", "h5py")),
    ):
        program = f"import sys, tisph.report.{module}; sys.exit(any(name in sys.modules for name in {others!r}))"
        assert subprocess.run([sys.executable, "-c", program]).returncode == 0
