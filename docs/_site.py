"""What the site needs besides the pages: pictures and configs of the repository, to which the pages link."""

from pathlib import Path

from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = {"media": ("*.png", "*.mp4"), "configs": ("*.yaml",)}


def on_files(files, config):
    """Add the files that pages reach by ``../media`` and ``../configs``, at the same names in the site."""
    for folder, patterns in FOLDERS.items():
        for path in sorted(path for pattern in patterns for path in (ROOT / folder).glob(pattern)):
            files.append(File.generated(config, f"{folder}/{path.name}", abs_src_path=str(path)))
    return files


def on_page_markdown(markdown, **_):
    """Links as they are in the site, in which docs/ is the root."""
    for folder in FOLDERS:
        markdown = markdown.replace(f"](../{folder}/", f"]({folder}/")
    return markdown
