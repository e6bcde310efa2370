"""Run docs/tutorial.md, block after block, and keep the pictures that it writes: `python scripts/tutorial.py`."""

import contextlib
import os
import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

PAGE = Path(__file__).resolve().parent.parent / "docs" / "tutorial.md"
QUALITY = 90  # of the JPEGs that the page shows


def blocks(text: str) -> list[str]:
    """Python of the page, in its order."""
    return re.findall(r"^```python\n(.*?)^```", text, flags=re.M | re.S)


def commands(text: str) -> list[str]:
    """Command lines of the page, each without `sdfprt`."""
    return re.findall(r"^    sdfprt (.+)$", text, flags=re.M)


def run(text: str, folder: Path) -> dict[str, Any]:
    """All blocks in one namespace, which comes back; what they write lies in `folder`."""
    names: dict[str, Any] = {}
    with contextlib.chdir(folder):
        for number, block in enumerate(blocks(text)):
            exec(compile(block, f"{PAGE.name}, block {number}", "exec"), names)
    return names


def shown(text: str) -> list[str]:
    """Stems of the pictures that the page shows."""
    return re.findall(r"\]\(tutorial/([\w-]+)\.jpg\)", text)


def main() -> None:
    """Draw all pictures of the page again; those whose names differ by a last number stand side by side."""
    text = PAGE.read_text()
    PAGE.with_suffix("").mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        run(text, Path(folder))
        for stem in shown(text):
            files = (
                [Path(folder, f"{stem}.png")]
                if Path(folder, f"{stem}.png").exists()
                else sorted(Path(folder).glob(f"{stem}-*.png"))
            )
            picture = np.concatenate([np.asarray(Image.open(file).convert("RGB")) for file in files], axis=1)
            path = PAGE.with_suffix("") / f"{stem}.jpg"
            Image.fromarray(picture).save(path, quality=QUALITY)
            print(path, f"{os.path.getsize(path) // 1024} KB")


if __name__ == "__main__":
    main()
