"""A real browser for tests: Debian's Chromium, or Playwright's own; skipped with the reason where there is none."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

__all__ = ["chromium"]

#: Debian's program before its launcher, which needs files of /etc besides.
_PLACES = ("/usr/lib/chromium/chromium", "chromium", "chromium-browser", "google-chrome")


@contextmanager
def chromium() -> Iterator:
    """A running browser of Playwright."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    found = next((path for path in map(shutil.which, _PLACES) if path), None)
    with playwright.sync_playwright() as started:
        own = Path(started.chromium.executable_path)
        if found is None and not own.exists():
            pytest.skip(f"no browser: none of {', '.join(_PLACES)}, nor {own}")
        browser = started.chromium.launch(executable_path=found, args=["--no-sandbox"])
        try:
            yield browser
        finally:
            browser.close()
