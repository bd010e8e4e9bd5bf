"""Films of runs in notebooks."""

import html
from pathlib import Path


class Film:
    """A page that plays a run. Notebooks display it; `save` writes it to a file."""

    def __init__(self, file: Path, width: int, height: int):
        self.page = file.read_text(encoding="utf-8")
        self.width, self.height = width, height

    def save(self, file) -> None:
        """Write the page to an `.html` file, which any browser can play from disk."""
        if Path(file).suffix not in (".html", ".htm"):
            raise ValueError(f"{file}: a film is written as an HTML page; expected a name that ends with .html or .htm")
        Path(file).write_text(self.page, encoding="utf-8")

    def _repr_html_(self) -> str:
        page = html.escape(self.page, quote=True)
        return (
            f'<iframe srcdoc="{page}" width="{self.width}" height="{self.height}" style="border: 0" '
            'sandbox="allow-scripts" title="Film of the run"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<Film of {len(self.page) // 1024} KiB; `save(FILE)` writes it>"
