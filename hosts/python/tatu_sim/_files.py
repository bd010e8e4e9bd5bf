"""Files that come with the package."""

from pathlib import Path
from typing import List

from . import _native

#: The folder of the package.
HERE = Path(__file__).resolve().parent

_SUFFIXES = (".toml", ".ttt", ".urdf", ".sdf")
#: Folders whose files belong to scenes in the folder above.
_PARTS = {"models", "parts", "plugin"}


def _is_part(name: str) -> bool:
    # Hidden folders contain edits that have not been saved.
    return name in _PARTS or name.startswith(".")


def scenes() -> List[str]:
    """Return the names of the scenes that come with the package; `World` accepts them instead of a path."""
    found = set()
    for folder in map(Path, _native.folders("scenes")):
        found.update(
            path.relative_to(folder).as_posix()
            for path in folder.rglob("*")
            if path.suffix in _SUFFIXES and not any(map(_is_part, path.relative_to(folder).parts)) and path.is_file()
        )
    return sorted(found)


def models() -> List[str]:
    """Return the names of the models that come with the package; scenes use them by `model = NAME`."""
    folders = [Path(folder) for folder in _native.folders("models")]
    return sorted({path.name for folder in folders for path in folder.iterdir() if (path / "model.toml").is_file()})
