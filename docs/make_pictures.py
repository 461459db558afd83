"""Draw the pictures of ``outputs.md`` and ``paper.md``: page, sheets, certificate, workbook and two plots.

Run from the checkout's root: ``python docs/make_pictures.py``. Needs chromium, poppler and LibreOffice.
"""

from __future__ import annotations

import re
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


def draw_shop() -> None:
    """Balance the V8 of ``shop.md`` and draw the plates of its sheet, and its certificate."""
    files = re.findall(
        r"```toml\n# (shop|v8)\.toml\n(.*?)```", (ROOT / "docs" / "shop.md").read_text("utf-8"), re.S
    )
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for name, text in files:
            (folder / f"{name}.toml").write_text(text, encoding="utf-8")
        main(["generate", "v8-crossplane", "-o", str(folder / "crank.stl"), "--segments", "48"])
        main(["balance", str(folder / "v8.toml"), "-o", str(folder / "out"), "--only", "pdf,certificate"])
        first_page(folder / "out" / "sheet.pdf", "sheet-webs", page=2)
        first_page(folder / "out" / "certificate.pdf", "certificate")


if __name__ == "__main__":
    draw()
    draw_shop()
