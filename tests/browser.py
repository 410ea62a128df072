"""Chromium without a screen: what it shows of a page, what it says on its console, and what it prints."""

import json
import re
import shutil
import subprocess
from html import escape, unescape
from pathlib import Path
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
CHROMIUM = next((path for name in NAMES if (path := shutil.which(name)) is not None), None)
WAIT = 240  # s: a busy machine takes its time to start a browser
WINDOW = "1500,2200"  # px: windows may not be narrower than 500, frames in them may
FRAME = """<!DOCTYPE html><title>frame</title>
<script>addEventListener("message", (event) => {{ document.body.dataset.seen = event.data; }});</script>
<body><iframe srcdoc="{page}" style="border: 0; width: {width}px; height: 2000px"></iframe></body>"""
needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="needs a browser: apt-get install chromium")


def chromium(folder: Path, *words: str) -> tuple[str, str]:
    """Return what Chromium writes, and its log; its own files stand in a ``folder``."""
    assert CHROMIUM is not None
    own = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--enable-logging=stderr")
    profile = f"--user-data-dir={folder / 'profile'}"
    command = [CHROMIUM, *own, profile, "--virtual-time-budget=5000", *words]
    done = subprocess.run(command, capture_output=True, text=True, timeout=WAIT, check=True)
    return done.stdout, done.stderr


def opened(folder: Path, html: str, width: int, probe: str) -> tuple[dict[str, Any], str]:
    """Return what a ``probe`` finds in a page that is ``width`` px wide, and what stands on the console.

    The probe is a program at the end of the page's head, which tells its parent.
    """
    frame = folder / "frame.html"
    page = escape(html.replace("</head>", f"{probe}</head>", 1))
    frame.write_text(FRAME.format(width=width, page=page), encoding="utf-8")
    shown, log = chromium(folder, f"--window-size={WINDOW}", "--dump-dom", frame.as_uri())
    found = re.search(r'data-seen="([^"]*)"', shown)
    assert found is not None, log[-2000:]
    seen: dict[str, Any] = json.loads(unescape(found[1]))
    return seen, "\n".join(line for line in log.splitlines() if "CONSOLE" in line)


def printed(folder: Path, html: str) -> Path:
    """Return the page on paper, as a PDF."""
    page, paper = folder / "page.html", folder / "page.pdf"
    page.write_text(html, encoding="utf-8")
    chromium(folder, "--no-pdf-header-footer", f"--print-to-pdf={paper}", page.as_uri())
    return paper
