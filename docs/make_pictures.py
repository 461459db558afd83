"""Draw the pictures of ``outputs.md``: the bundled crank's page, sheet, workbook and two plots.

Run from the checkout's root: ``python docs/make_pictures.py``. Needs chromium, poppler and LibreOffice.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"
BROWSER = (
    "--headless",
    "--no-sandbox",
    "--hide-scrollbars",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--virtual-time-budget=8000",
)
JOBS = ROOT / "fixtures" / "crf250r" / "drafted"
sys.path.insert(0, str(ROOT))

from autobalance.command import main  # noqa: E402


def run(*command: str | Path) -> None:
    """Run a program; what it says is shown only where it fails."""
    done = subprocess.run([str(each) for each in command], capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{command[0]} failed:\n{done.stdout}{done.stderr}")


def first_page(document: Path, name: str, dots_per_inch: int = 70, page: int = 1) -> None:
    """Draw a page of a PDF."""
    pages = ["-f", str(page), "-l", str(page), "-r", str(dots_per_inch)]
    run("pdftoppm", "-png", "-singlefile", *pages, document, PICTURES / name)


def draw() -> None:
    """Balance the bundled crank and draw what was written."""
    PICTURES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "result"
        main(["balance", str(JOBS / "factor-0.28.toml"), "-o", str(folder)])
        picture = f"--screenshot={PICTURES / 'page.png'}"
        run("chromium", *BROWSER, "--window-size=1100,1400", picture, (folder / "report.html").as_uri())
        first_page(folder / "sheet.pdf", "sheet")
        run("soffice", "--headless", "--convert-to", "pdf", "--outdir", scratch, folder / "balance.xlsx")
        first_page(Path(scratch) / "balance.pdf", "workbook")
        job = ["--set", "engine.rod_length_mm=104.0", "--plots", str(folder / "plots")]
        main(["forces", str(JOBS / "factor-0.28.toml"), *job])
        for name in ("force-polar", "orders"):
            shutil.copyfile(folder / "plots" / f"{name}.png", PICTURES / f"{name}.png")


if __name__ == "__main__":
    draw()
