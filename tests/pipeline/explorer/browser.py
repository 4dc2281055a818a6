"""A real browser for tests: Debian's Chromium, or Playwright's own; skipped with the reason where there is none."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

__all__ = ["chromium"]

#: Debian's program before its launcher, which needs files of /etc besides.
_PLACES = ("/usr/lib/chromium/chromium", "chromium", "chromium-browser", "google-chrome")


@contextmanager
def chromium() -> Iterator:
    """A running browser of Playwright, the first that starts."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    reasons = []
    with playwright.sync_playwright() as driver:
        for path in (*filter(None, map(shutil.which, _PLACES)), driver.chromium.executable_path):
            try:
                browser = driver.chromium.launch(executable_path=path, args=["--no-sandbox"])
            except playwright.Error as error:
                reasons.append(f"{path}: {str(error).splitlines()[0]}")
                continue
            try:
                yield browser
            finally:
                browser.close()
            return
        pytest.skip(f"no browser can be started here: {'; '.join(reasons)}")
