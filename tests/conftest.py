"""What several test files share."""

import pytest

from drakesep.studies import Verification, verify


@pytest.fixture(scope="session")
def vega_verification(tmp_path_factory: pytest.TempPathFactory) -> Verification:
    """The main job, done once; its folder is in `folder`."""
    folder = tmp_path_factory.mktemp("vega")
    study = verify("vega", output=folder)
    study.folder = folder
    return study
