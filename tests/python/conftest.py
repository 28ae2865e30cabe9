"""Where the checks of a run's folder find it."""

import os
from pathlib import Path

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--run", default=os.environ.get("RSPH_RUN"), help="folder of a finished run")


@pytest.fixture(scope="session")
def run(request: pytest.FixtureRequest) -> Path:
    folder = request.config.getoption("--run")
    if folder is None:
        pytest.fail("give the folder of a finished run: --run FOLDER or RSPH_RUN=FOLDER")
    return Path(folder)
