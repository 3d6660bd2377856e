"""Every key that a config accepts has an effect on numbers, files or pictures; any other key is refused.

The keys are those of the models, as in ``tisph keys``. In each config of ``data/every_key.yaml`` each key gets other
values. One that is accepted must change the first steps or the numbers of a sample, a frame of the movie, or the plan
of the files. A key that no config of its scene accepts fails, too: a config that uses it is missing.
"""

import contextlib
import copy
import functools
import inspect
import itertools
import re
import types
import typing
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import ValidationError

import tisph
from tisph import registry, scenes
from tisph.config import reference, schema
from tisph.config.base import Model
from tisph.config.fields import Member
from tisph.config.schema import model_of
from tisph.config.yaml_text import parse
from tisph.errors import ConfigError, DivergedError
from tisph.folder import Folder
from tisph.measures.metrics import sample_metrics
from tisph.report.movie import Movie
from tisph.schemes import resolve
from tisph.simulation import recording

pytestmark = pytest.mark.taichi

DATA = Path(__file__).parent / "data"
FORMS = parse((DATA / "every_key.yaml").read_text(encoding="utf-8")).data
SHARED = FORMS.pop("shared")
NAMES = [f"{scene}: {form}" for scene, forms in FORMS.items() for form in forms]

PARTNERS = {
    "walls.top.smooth": {"walls.top.corner_radius": 0.2},
    "walls.bottom.smooth": {"walls.bottom.corner_radius": 0.2},
    "discretisation.spacing": {"discretisation.particles_across": None},
    "fluid.dynamic_viscosity": {"fluid.kinematic_viscosity": None},
    "fluid.rheology.modes.fraction": {"fluid.rheology.solvent_fraction": 0.425},
    "sphere.free": {"sphere.velocity": None, "sphere.force": 1.0},
    "output.video.dye": {"output.video.color_by": "dye"},
    "scheme.largest_strain": {"time.tolerance": 0.1},
    "units.mass": {"output.video.color_by": "pressure"},
    "temperature.unit": {"output.video.color_by": "temperature"},
    "bodies.file.unit": {"bodies.0.file.scale": 0.38},
    **{
        f"walls.{side}.file.{key}": {"geometry.length": length, "discretisation.particles_across": across}
        for side in ("top", "bottom")
        for key, length, across in (("scale", 3.0, 20), ("unit", 5.08, 25))
    },
}
"""Key -> other keys, with the values that they need beside it."""

WITHOUT = {
    "bodies": "a list of shapes, whose keys are varied one by one",
    "fluid.rheology.modes": "a list of polymers, whose keys are varied one by one",
    "temperature.viscosity.type": "a law is varied as a whole",
    "walls.around": "a shape, whose keys are varied one by one",
    "name": "of the folder of results, which other tests see",
    "accuracy": "makes further runs, and changes none",
    "runtime.threads": "any number of them gives the same bits",
    "discretisation.precision": "starts Taichi anew, for seconds: tests with the marker other_program do",
    "channel: first, units.mass": "no number with a mass is in a frame of parallel flow",
}
"""Exceptions: keys that are not varied, or only in other forms, and the reason."""

REFUSED = {
    "eccentric_annulus": r"walls\.treatment|initial\.time",
    "channel": r"ends\.(left|right)\.type",  # both have to be exchanged
    "region": r"walls\..*\.(velocity_before|shear_stress|stress_amplitude|stresses|velocities|times|mass_per_area)"
    r"|turning\.angular_velocity_before|ends\.(left|right)\.(type|pressure)",
    "pipe": r"ends\.(left|right)\.(type|pressure)",
    "taylor_couette": r"walls\.(inner|outer)\.angular_velocity_before",
}
"""Scene -> pattern of the keys of a model that it shares with other scenes, and that it always refuses."""

OUTPUT = re.compile(r"(title|units|output|time\.(end|samples)|temperature\.unit)\b")
PLANNED = re.compile(r"(time\.(end|samples)|output\.(checkpoint_every|vtk|video\.frames|video))$")
OFTEN = re.compile(r"(discretisation\.(kernel|smoothing_ratio)|scheme|scheme\..*|time\.(cfl|tolerance))$")
"""Keys of all scenes that are varied in each form; the others in the forms of ``WHOLE``, and in slow tests in all."""

WHOLE = {"channel: first"}


def data_of(name):
    """Return the raw data of a form."""
    scene, form = name.split(": ")
    changes = [{}, FORMS[scene][form]][form != "first"]
    return functools.reduce(merged, [SHARED, {"name": "run", "scene": scene}, FORMS[scene]["first"], changes])


def merged(base, changes):
    """Return ``base`` with ``changes`` of values in nested maps; lists, and maps with a type, are values."""
    both = dict(base)
    for key, value in changes.items():
        nested = isinstance(value, dict) and isinstance(both.get(key), dict) and "type" not in value
        both[key] = merged(both[key], value) if nested else value
    return both


def loaded(data):
    """Return the checked config."""
    return model_of(data).model_validate(data, context={"folder": DATA, "data": data})


def place_of(key):
    """Return the place of a dotted key, the numbers of items as numbers."""
    return [int(part) if part.isdecimal() else part for part in key.split(".")]


def put(data, place, value):
    """Return ``data`` with a ``value`` at a ``place``; maps on the way are made."""
    data = at = copy.deepcopy(data)
    for part in place[:-1]:
        if isinstance(at, dict) and at.get(part) is None:
            at[part] = {}
        at = at[part]
    at[place[-1]] = value
    return data


def alternatives(annotation, metadata=()):
    """Yield the types in a union, each with the constraints and marks around it."""
    metadata = list(reference.constraints(metadata))
    while typing.get_origin(annotation) is typing.Annotated:
        annotation, *more = typing.get_args(annotation)
        metadata += reference.constraints(more)
    if typing.get_origin(annotation) in (typing.Union, types.UnionType):
        for each in typing.get_args(annotation):
            yield from alternatives(each, metadata)
    else:
        yield annotation, metadata


def walk(model, data, place=()):
    """Yield place, types and written value of each key of a ``model``, and below it, of the first item of lists."""
    for name, field in model.model_fields.items():
        value, here = (data or {}).get(name), (*place, name)
        kinds = list(alternatives(field.annotation, field.metadata))
        yield here, kinds, value
        for kind, metadata in kinds:
            inside, lower = value, here
            if typing.get_origin(kind) is tuple and isinstance(value, list):
                kind, metadata = next(alternatives(typing.get_args(kind)[0]))
                inside, lower = value[0], (*here, 0)
            member = next((mark for mark in metadata if isinstance(mark, Member)), None)
            plain = isinstance(kind, type) and issubclass(kind, Model)
            found = member.model(inside) if member else kind if plain else None
            if found and found is not Model and (inside is None or isinstance(inside, dict)):
                yield from walk(found, inside, lower)


def values(kind, metadata, value, required):
    """Yield values of a type that differ from ``value``; ``required``: the keys of members by their names."""
    member = next((mark for mark in metadata if isinstance(mark, Member)), None)
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    number = value if isinstance(value, int | float) and not isinstance(value, bool) else None
    if member:
        names = [name for name in registry.names(member.family) if name != "auto"]  # which is one of the others
        yield from (required.get(name, {"type": name}) for name in names)
    elif origin is typing.Literal:
        yield from inner
    elif kind is bool:
        yield not value
    elif kind is int:
        yield from (8, 3) if number is None else (number + 1, number + 2, 2 * number)
    elif kind is float:
        yield from (1.25 * number, 0.5 * number, 2 * number, 0.9 * number) if number else (0.3, 0.06, 1.2, 4.0)
    elif kind is str:
        known = [inspect.getclosurevars(one.func).nonlocals for one in metadata if hasattr(one, "func")]
        yield from (name for one in known for name in (registry.names(one["family"]) if "family" in one else ["other"]))
    elif origin is tuple and isinstance(value, list) and value:
        for index in sorted(range(len(value)), key=lambda index: abs(index - len(value) // 2)):
            for changed in values(*next(alternatives(inner[0])), value[index], required):
                yield [*value[:index], changed, *value[index + 1 :]]
    elif origin is tuple and inner[-1] is not ...:
        yield from map(list, zip(*(values(*next(alternatives(each)), None, required) for each in inner), strict=True))


REQUIRED = {
    member["type"]: member
    for forms in FORMS.values()
    for form in forms.values()
    for member in (form.get("fluid", {}).get("rheology"), *(form["bodies"] if type(form.get("bodies")) is list else ()))
    if member and "type" in member
}


OF_FILES = {
    "path": [["others.svg"]] * 2,
    "unit": [["in"]] * 2,
    "part": [["b"], ["hill"]],
    "scale": [[], [1.5]],
    "angle": [[], [np.pi, 0.0]],
}
"""Key of a file -> other values for a body, and for a wall."""


def candidates(place, kinds, value, settings):
    """Return a few other values of a key; ``settings``: the config."""
    key = dotted(place)
    if key == "output.video.color_by":
        return schema.colours(settings)[::-1]
    if key == "output.video.limits":
        return [[0.0, 0.3]]
    if key == "bodies.shares":
        return [value[::-1]]
    if key in ("output.video.width", "output.video.height"):
        return [value + 80]
    if key == "discretisation.spacing":
        return [settings.across / (settings.particles_across + more) for more in (1, 2, 4)]
    if key == "discretisation.refine":
        return ["auto"] if value and "near" in value[0] else []  # its first run is whole: in one form
    if key == "temperature.viscosity":
        return [{"type": "exponential", "coefficient": 0.02}]
    if key in ("temperature.walls", "scalars.walls"):
        return [{"top": 0.3}]
    if key == "discretisation.refine.near":
        return ["walls.bottom"]
    if re.search(r"\.file\.(path|unit|part)$", key) or re.match(r"walls\..*\.file\.(scale|angle)$", key):
        return OF_FILES[key.rpartition(".")[2]][key.startswith("walls")]
    found = [each for kind, metadata in kinds for each in values(kind, metadata, value, REQUIRED)]
    if key == "scheme":  # auto is one of the others
        found = [each for each in found if each["type"] != resolve(settings)[0].scheme.type]
    return [each for each in found if each != value][:6]


def dotted(place):
    """Return the dotted key of a place, without the numbers of items."""
    return ".".join(part for part in place if isinstance(part, str))


def below(data, part):
    """Return the value of a key, or an item; None where there is none."""
    if isinstance(data, dict):
        return data.get(part)
    return data[part] if isinstance(data, list) and isinstance(part, int) else None


@functools.cache
def form(name):
    """Return data and config of a form, and place, types and value of each of its keys with other values."""
    data = data_of(name)
    settings = loaded(data)
    resolved, found = settings.model_dump(mode="json"), {}
    for place, kinds, value in walk(type(settings), data):
        if value is None:
            value = functools.reduce(below, place, resolved)
        key = dotted(place)
        others = candidates(place, kinds, value, settings)
        if others and key not in ("scene", *WITHOUT) and f"{name}, {key}" not in WITHOUT:
            found[key] = place, others
    return data, settings, found


@functools.cache
def accepted(name, key):
    """Return the values of a key that a form accepts, at most three: config without it, config with it, value."""
    data, settings, found = form(name)
    place, others = found[key]
    pairs = []
    for other in others:
        before, after = data, put(data, place, other)
        for partner, needed in PARTNERS.get(key, {}).items():
            before, after = (put(each, place_of(partner), needed) for each in (before, after))
        with contextlib.suppress(ValidationError):
            after = loaded(after)
            with contextlib.suppress(ValidationError):  # or the key takes the place of its partner
                settings = loaded(before) if before is not data else settings
            pairs.append((settings, after, other))
        if len(pairs) == 3:
            break
    return pairs


def measured(settings, scene, state):
    """Return what is recorded of a state, and its numbers in ``summary.json``."""
    series = scene.time_series(**settings.time_series)
    values = series.measure(state)
    record = np.array([state.t]), values[None]
    if scene.parallel:
        heights = scene.probe_positions(4)[1]
        record = heights, scene.exact_velocity(heights, state.t)
    return series.columns, values.tobytes(), scene.reynolds, repr(sample_metrics(scene, state, record))


def plain(state, above=""):
    """Yield the names and bits of all arrays and numbers of a snapshot."""
    for name, value in vars(state).items():
        if hasattr(value, "__dataclass_fields__"):
            yield from plain(value, f"{name}.")
        elif isinstance(value, dict):
            yield from ((f"{name}.{key}", array.tobytes()) for key, array in value.items())
        else:
            yield above + name, value.tobytes() if isinstance(value, np.ndarray) else repr(value)


def film(settings, state, folder):
    """Return a frame of the movie, and the bytes of the movie of this frame alone if ``folder`` is given."""
    scene, video = scenes.of(settings), settings.output.video
    with Movie(folder / "movie.mp4", scene, video, settings.heading, settings.time.end) as movie:
        if video.fps == 30:
            return movie.frame(state).tobytes()
        movie.add(state)
    return (folder / "movie.mp4").read_bytes()


class Outcomes:
    """What comes of the configs of one form, each computed once."""

    def __init__(self, folder):
        self.folder, self.known = folder, {}

    def __call__(self, kind, settings, *arguments):
        place = kind, settings.resolved_yaml(), *arguments
        if place not in self.known:
            self.known[place] = getattr(self, kind)(settings, *arguments)
        return self.known[place]

    def stepped(self, settings, steps):
        """Return the scene, and the state after some ``steps``; or the error."""
        try:
            with tisph.Simulation(settings) as simulation:
                for _ in range(steps):
                    simulation.step()
                return simulation.scene, simulation._last_step().at(simulation.time)
        except DivergedError as error:
            return str(error)

    def arrays(self, settings, steps):
        reached = self("stepped", settings, steps)
        return reached if isinstance(reached, str) else dict(plain(reached[1]))

    def measured(self, settings, steps):
        reached = self("stepped", settings, steps)
        return reached if isinstance(reached, str) else measured(settings, *reached)

    def plan(self, settings):
        """Return the files that a run writes, and when."""
        folder = self.folder / str(len(self.known))
        folder.mkdir()
        with tisph.Simulation(settings) as simulation:
            record = recording.Recording(simulation, Folder(folder), pictures=False, video=True)
            schedules = [(type(each).__name__, sorted(vars(each.schedule).items())) for each in record.added]
            for each in record.observers:
                each.close()
        return repr(schedules)


SEEN = list(itertools.product((1, 5), ("arrays", "measured")))
"""Numbers of steps, and what is compared after them: the quickest first."""


def without_effect(name, keys, folder, monkeypatch):
    """Return the accepted keys among those for which ``keys(key)`` is true that change nothing, with values."""
    monkeypatch.setattr(recording, "movie", lambda *_: SimpleNamespace(add=print, close=lambda: None))
    outcome, dead, state = Outcomes(folder), {}, None
    for key in filter(keys, form(name)[2]):
        for before, after, _ in accepted(name, key):
            if PLANNED.match(key):
                same = outcome("plan", before) == outcome("plan", after)
            elif OUTPUT.match(key):
                state = state or outcome("stepped", form(name)[1], 1)[1]
                same = film(before, state, folder) == film(after, state, folder)
            else:
                same = all(outcome(kind, before, n) == outcome(kind, after, n) for n, kind in SEEN)
            if not same:
                break
        else:
            dead[key] = [other for _, _, other in accepted(name, key)]
    return {key: others for key, others in dead.items() if others}


def named(data):
    """Yield the dotted keys in maps and in the first items of lists."""
    for key, value in data.items():
        yield key
        inside = value[0] if isinstance(value, list) else value
        yield from (f"{key}.{below}" for below in named(inside if isinstance(inside, dict) else {}))


def own(name):
    """Return a function that tells the keys of a form that are varied in every run of the tests.

    They are those that it names, in the first form all keys of its scene; of the keys of all scenes those of ``OFTEN``.
    """
    scene, chosen = name.split(": ")
    shared, written = reference.scene_keys()[0], set(named(FORMS[scene][chosen]))

    def varied(key):
        if OFTEN.match(key) and name not in WHOLE:
            return chosen == "first" or "scheme" in written
        named_here = key in written if chosen != "first" else key not in shared and not key.startswith("fluid.")
        return name in WHOLE or named_here

    return varied


QUICK = {"channel: first", "channel: swinging", "channel: stresses", "channel: carreau_yasuda", "channel: stress below"}
QUICK |= {"channel: free body", "channel: stream", "annulus: first", "annulus: before"}
"""Forms that fit into a minute of processor time and have all kinds of keys; the others are slow."""


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name not in QUICK)) for name in NAMES])
def test_an_accepted_key_has_an_effect(name, tmp_path, monkeypatch):
    assert without_effect(name, own(name), tmp_path, monkeypatch) == {}


@pytest.mark.slow  # the keys that are left, most of them of all scenes
@pytest.mark.parametrize("name", NAMES)
def test_an_accepted_key_has_an_effect_in_every_form(name, tmp_path, monkeypatch):
    quick = own(name)
    assert without_effect(name, lambda key: not quick(key), tmp_path, monkeypatch) == {}


@pytest.mark.parametrize(
    "scene", [pytest.param(scene, marks=pytest.mark.slow if scene == "channel" else []) for scene in FORMS]
)
def test_every_key_of_a_scene_is_accepted_by_a_config(scene):
    """Keys of all scenes, and of members of families such as fluids and shapes, in a channel."""
    names, shared = [f"{scene}: {chosen}" for chosen in FORMS[scene]], reference.scene_keys()[0]
    keys = dict.fromkeys(key for name in names for key in form(name)[2])
    if scene != "channel":
        own_keys = dict(reference.fields(registry.load("scenes", scene).Config))
        keys = [key for key in keys if key in own_keys and key not in shared]
    varied = {name: own(name) for name in names}
    told = {key: [name for name in names if key in form(name)[2] and varied[name](key)] for key in keys}
    never = {key for key in keys if not any(accepted(name, key) for name in told[key])}
    assert {key for key in never if not re.fullmatch(REFUSED.get(scene, ""), key)} == set()


REFUSALS = [
    ("channel: first", "discretisation.kernel", "wendland_c2", "or give scheme: {type: wcsph}"),
    ("cavity: first", "discretisation.smoothing_ratio", 1.2, "no smoothing kernel: leave it out"),
    ("channel: implicit", "scheme.largest_courant", 0.5, "whose steps have a largest_strain"),
    ("cavity: regular", "scheme.largest_strain", 0.6, "whose steps have a largest_courant"),
    ("channel: implicit", "scheme.error_ratio", 0.5, "is for two-dimensional flow"),
    ("channel: Courant number", "time.tolerance", 1e-5, "does nothing beside time.cfl"),
    ("channel: Courant number", "scheme.accuracy", "high", "does nothing beside time.cfl"),
    ("region: first", "scheme.type", "wcsph", "no wall treatment for scene region"),
    ("region: first", "walls.top.velocity_before", 0.5, "the fluid is at rest at first"),
    ("region: first", "contact.distance", 0.3, "give one the motion free, or leave it out"),
    ("region: outlines", "walls.top.outline", [[0, 1], [2, 0.8]], "both ends of a periodic wall must be at one height"),
    ("channel: stream", "initial.jitter", 0.2, "0.3 to 0.5 with open ends"),
]
"""Forms with a key that would have no effect there, and what the error says."""


@pytest.mark.parametrize(("name", "key", "value", "said"), REFUSALS)
def test_a_key_that_would_have_no_effect_is_refused_in_words(name, key, value, said):
    changed = put(data_of(name), key.split("."), value)
    with pytest.raises(ConfigError) as refused:
        tisph.Simulation(changed)
    (line,) = str(refused.value).splitlines()
    assert (said in line, key.removesuffix(".distance") in line) == (True, True)


@pytest.mark.parametrize("name", NAMES)
def test_a_resolved_config_loads_again(name):
    settings = form(name)[1]
    assert loaded(parse(settings.resolved_yaml()).data) == settings
