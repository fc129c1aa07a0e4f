"""What several test files share."""

import hypothesis
import pytest

from drakesep.studies import Verification, verify


# A busy machine is not a failure.
hypothesis.settings.register_profile("drakesep", deadline=None)
hypothesis.settings.load_profile("drakesep")


@pytest.fixture(scope="session")
def vega_verification(tmp_path_factory: pytest.TempPathFactory) -> Verification:
    """The main job, done once; its folder is in `folder`."""
    folder = tmp_path_factory.mktemp("vega")
    study = verify("vega", output=folder)
    study.folder = folder
    return study
