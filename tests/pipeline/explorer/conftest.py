"""One browser and one explorer for all tests of a process: they open pages, which is cheap."""

import pytest

from tests.pipeline.explorer.browser import chromium
from tests.pipeline.explorer.serving import served_plane, serving


@pytest.fixture(scope="session")
def browser():
    with chromium() as started:
        yield started


@pytest.fixture(scope="session")
def window(browser):
    """What pages of the explorer have in common, so that scripts are loaded once."""
    context = browser.new_context(accept_downloads=True)
    yield context
    context.close()


@pytest.fixture(scope="session")
def served(tmp_path_factory):
    folder = tmp_path_factory.mktemp("served")
    served_plane(folder)
    with serving(folder) as found:
        yield found
