"""The page of keys, a page of the site: the reference of ``tisph keys`` (``tisph.config.reference``) as tables."""

from tisph import registry
from tisph.config.reference import FAMILIES, MEANINGS, about, member_keys, rows, scene_keys, summary
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


def table(entries, above=""):
    """Lines of a table of keys with their fields; ``above`` is what stands before them in ``keys.yaml``."""
    lines = []
    for key, *others in rows(entries, above):
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in (f"`{key}`", *others)) + " |\n")
    return HEAD + "".join(lines)


PAGES = {"reference/keys.md": keys_page}
"""Generated pages of the site, by their names."""
