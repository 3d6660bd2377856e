"""The page of keys, a page of the site: the reference of ``tisph keys`` (``tisph.config.reference``) as tables."""

from types import SimpleNamespace

from tisph import registry
from tisph.config import schema
from tisph.config.reference import FAMILIES, MEANINGS, code, member_keys, rows, scene_keys, summary
from tisph.studies import sweep

WITHOUT_KEYS = {
    "kernels": "Kernels: `discretisation: {kernel: NAME}`",
    "operators": "Operators of scheme wcsph: `scheme: {type: wcsph, operators: NAME}`",
}
HEAD = "| key | meaning | unit | allowed | default |\n|---|---|---|---|---|\n"


def keys_page():
    """The page of all keys, as Markdown."""
    parts = [
        "# Keys of a config\n\nThis page is generated from the program; `tisph keys` prints it. Units are those of "
        "the config itself: any self-consistent system will do. A key without a default must be given.\n\n",
        "## All scenes\n\n",
    ]
    shared, scenes = scene_keys()
    parts.append(table(shared))
    for name, own in scenes.items():
        parts.append(f"\n## Scene `{name}`\n\n{summary('scenes', name)} {about(name)}\n\n")
        parts.append(table(own))
    for family, title in FAMILIES.items():
        parts.append(f"\n## {title}\n\n")
        for name in registry.names(family):
            parts.append(f"\n### `{name}`\n\n{summary(family, name)}\n\n")
            parts.append(table(*member_keys(family, name)))
    for family, title in WITHOUT_KEYS.items():
        lines = [f"- `{name}`: {registry.summary(family, name)}\n" for name in registry.names(family)]
        parts.append(f"\n## {title}\n\n{''.join(lines)}")
    return "".join([*parts, study_table()])


def study_keys():
    """Keys of the file of a sweep, as they stand in ``keys.yaml``."""
    ranged = [f"study/vary.KEY.{key}" for key in sorted(sweep.RANGE)]
    return [name for key in sweep.KEYS for name in (f"study/{key}", *(ranged if key == "vary" else []))]


def study_table():
    """The part on the file of a sweep, which no model describes."""
    head = "\n## File of a sweep: `tisph sweep STUDY.yaml`\n\n| key | meaning | default |\n|---|---|---|\n"
    lines = [(key.partition("/")[2], MEANINGS[key]) for key in study_keys()]
    return head + "".join(f"| `{key}` | {meaning} | {' '.join(said)} |\n" for key, (meaning, _, *said) in lines)


def about(scene):
    """Return sentences about the meaning of the resolution in a scene, and about the colours of its movie."""
    model = registry.load("scenes", scene).Config
    texts = [f"`discretisation.particles_across` counts the particles across {model.across_name}."]
    optional = "bodies" in model.model_fields and not model.model_fields["bodies"].is_required()
    plain = {name: colours(scene, name) for name in registry.names("rheology")}
    with_bodies = {name: colours(scene, name, bodies=(None,)) for name in plain}
    if optional and plain != with_bodies:
        cases = [("without bodies ", plain), ("with bodies ", with_bodies)]
    else:
        cases = [("", with_bodies)]
    if "coordinates" in model.model_fields:
        around = {name: colours(scene, name, coordinates="axisymmetric") for name in plain}
        cases.append(("with `coordinates: axisymmetric` ", around))
    return " ".join([*texts, *(colour_text(words, by_law) for words, by_law in cases)])


def colours(scene, law, bodies=(), **given):
    """Return values of ``output.video.color_by`` for a scene and a fluid law; ``given``: other keys of its config."""
    fluid = SimpleNamespace(rheology=registry.load("rheology", law).Parameters.model_construct())
    given |= {"bodies": bodies} if "bodies" in registry.load("scenes", scene).Config.model_fields else {}
    return schema.colours(registry.load("scenes", scene).Config.model_construct(fluid=fluid, **given))


def colour_text(words, by_law):
    """Return the colours of all laws, and those that some laws add, in one or two sentences."""
    shared = [name for name in by_law["oldroyd_b"] if all(name in names for names in by_law.values())]
    added = {}
    for law, names in by_law.items():
        added.setdefault(tuple(name for name in names if name not in shared), []).append(law)
    more = "; ".join(f"with {code(laws)} also {code(names)}" for names, laws in added.items() if names)
    text = f"A movie {words}can show (`output.video.color_by`) {code(shared)}"
    return f"{text}; {more}." if more else f"{text}."


def table(entries, above=""):
    """Lines of a table of keys with their fields; ``above`` is what stands before them in ``keys.yaml``."""
    lines = []
    for key, *others in rows(entries, above):
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in (f"`{key}`", *others)) + " |\n")
    return HEAD + "".join(lines)


PAGES = {"reference/keys.md": keys_page}
"""Generated pages of the site, by their names."""
