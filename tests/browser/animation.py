"""The workbench in a few pictures, one after the other: map, bump, Try, Add, and the error has fallen.

    python -m tests.browser.animation -o docs/img/workbench_session.webp

The project of `benchmarks.workbench`, driven by clicks; a ring marks what is clicked next. Needs playwright
and Chromium (name it in CHROMIUM).
"""

import argparse
import io
import os
import shutil
import sys
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.workbench import project, served
from PIL import Image, ImageDraw, ImageFont

_SIZE = (1200, 760)  # px of the page
_WIDTH = 900  # px of a picture
_SHOWN = 1800  # ms of a picture
_PATIENCE = 600_000  # ms


@dataclass
class Film:
    """The pictures so far of one tab."""

    tab: Any
    pictures: list[Image.Image] = field(default_factory=list)

    def take(self, words: str, top: str, clicked: str = "") -> None:
        """A picture that begins at one part, with a ring around what is clicked next; then the click."""
        by = self.tab.get_by_test_id
        by(top).first.evaluate("e => scrollTo(0, e.getBoundingClientRect().top + scrollY - 90)")
        self.tab.wait_for_timeout(1200)
        image = Image.open(io.BytesIO(self.tab.screenshot())).convert("RGB")
        draw = ImageDraw.Draw(image)
        if clicked:
            box = by(clicked).first.bounding_box()
            left, low = box["x"] - 6, box["y"] - 6
            ring = (left, low, left + box["width"] + 12, low + box["height"] + 12)
            draw.rounded_rectangle(ring, 10, outline="#b5480d", width=5)
        at = (0, image.height - 44, image.width, image.height)
        draw.rectangle(at, fill="#1c2126")
        draw.text((16, image.height - 38), words, fill="white", font=ImageFont.load_default(24))
        self.pictures.append(image.resize((_WIDTH, round(_WIDTH * image.height / image.width))))
        if clicked:
            by(clicked).first.click()

    def save(self, path: Path) -> None:
        """As one animated picture."""
        path.parent.mkdir(parents=True, exist_ok=True)
        first, *rest = self.pictures
        first.save(path, save_all=True, append_images=rest, duration=_SHOWN, loop=0, quality=70, method=6)


def session(film: Film, url: str) -> None:
    """From the checks to the law that was added."""
    tab, by = film.tab, film.tab.get_by_test_id

    def there(name: str) -> None:
        by(name).first.wait_for(timeout=_PATIENCE)

    tab.goto(url)
    by("role-3").get_by_text("leave out").click()
    tab.wait_for_timeout(1000)
    by("check").click()
    there("sound")
    film.take("The logs have passed their checks", "folder", "place-where")
    by("compare").click()
    there("where-sentence")
    by("job-ask").wait_for(state="detached", timeout=_PATIENCE)
    film.take("Where: the error of every equation over its floor, by frequency", "where-sentence")
    film.take("The residual leaves the ribbon: click on a bump", "traces", "bump-1")
    there("whole")
    film.take("Which law would explain it?", "traces", "to-why")
    there("law-1")
    film.take("Why: laws by what they take of this bump. Try one", "stretch", "try-1")
    tab.wait_for_function(_DRAWN, arg=["waveform", 4], timeout=_PATIENCE)
    film.take("What would be left. Add it", "stretch", "law-add-1")
    there("version-1")
    film.take("Fitted and judged, on held-out and on fitted logs: the errors have fallen", "outcome")
    by("job-compare").wait_for(state="detached", timeout=_PATIENCE)
    by("job-ask").wait_for(state="detached", timeout=_PATIENCE)
    by("place-where").click()
    there("where-sentence")
    film.take("The new model on the same logs", "where-sentence")


_DRAWN = "([id, n]) => document.querySelector(`[data-testid=${id}]`)?.data?.length >= n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])  # pyright: ignore[reportOptionalMemberAccess]
    parser.add_argument("-o", "--out", type=Path, default=Path("out/workbench_session.webp"))
    out = parser.parse_args().out
    from playwright.sync_api import sync_playwright

    chromium = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
    flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with TemporaryDirectory() as made:
        folder = Path(made) / "my_project"
        folder.mkdir()
        project(folder)
        with served(folder) as (url, _), sync_playwright() as tools:
            browser = tools.chromium.launch(executable_path=chromium, args=flags)
            film = Film(browser.new_page(viewport={"width": _SIZE[0], "height": _SIZE[1]}))
            film.tab.set_default_timeout(_PATIENCE)
            session(film, url)
            browser.close()
    film.save(out)
    print(f"{out}: {len(film.pictures)} pictures, {out.stat().st_size / 1e6:.2f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
