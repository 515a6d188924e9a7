"""The documentation builds strictly and without a network, and its pages fetch nothing."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.pages import ROOT

pytestmark = pytest.mark.slow
MKDOCS = shutil.which(str(Path(sys.executable).with_name("mkdocs"))) or shutil.which("mkdocs")
# What a browser fetches by itself: scripts, styles, pictures and fonts, but no links.
FETCHED = re.compile(r"<(?:script|link|img|iframe)\b[^>]*?(?:src|href)=[\"']?(https?:|//)[^>]*>")
LINKS_ONLY = re.compile(r"rel=[\"']?(?:canonical|prev|next)")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if MKDOCS is None:
        pytest.skip("mkdocs is not installed: make docs installs it")
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [MKDOCS, "build", "--strict", "-q", "--site-dir", str(folder)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        env={
            "PATH": str(Path(MKDOCS).parent),
            "NO_MKDOCS_2_WARNING": "1",
            "http_proxy": "http://0",
        },
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def test_every_page_is_there(site: Path) -> None:
    for page in (ROOT / "docs").rglob("*.md"):
        assert (site / page.relative_to(ROOT / "docs")).with_suffix(".html").exists(), page
    assert not list(site.rglob("*.py")) + list(site.rglob("deviations.yaml"))


def test_formulas_are_drawn_without_a_script(site: Path) -> None:
    text = (site / "solvers.html").read_text(encoding="utf-8")
    assert text.count("<math") > 20
    assert "$`" not in text


def test_pages_fetch_nothing_from_elsewhere(site: Path) -> None:
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        found = [m[0] for m in FETCHED.finditer(text) if not LINKS_ONLY.search(m[0])]
        assert not found, f"{page.name}: {found}"
