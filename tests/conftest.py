"""What several test files share."""

import functools
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import hypothesis
import pytest
from matplotlib.figure import Figure
from small_case import small_case, write_case
from xdist.scheduler import LoadFileScheduling

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.requirements import deviation_limits
from drakesep.case_file.case import Case
from drakesep.case_file.reader import load_case
from drakesep.results.folder import ResultsFolder
from drakesep.studies.verification import verify
from drakesep.studies.verified import Verification
from drakesep.studies.worst_case import speed


# A busy machine is not a failure.
hypothesis.settings.register_profile("drakesep", deadline=None)
hypothesis.settings.load_profile("drakesep")


class _ByFileAndMainJob(LoadFileScheduling):
    """Gives whole files to processes, and all that want the main job to one of them."""

    def _split_scope(self, nodeid: str) -> str:
        file = str(super()._split_scope(nodeid))
        return "the main job" if _wants_main_job(file) else file


@functools.cache
def _wants_main_job(file: str) -> bool:
    text = (Path(__file__).parents[1] / file).read_text(encoding="utf-8")
    return "vega_verification" in text


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    return _ByFileAndMainJob(config, log)


@pytest.fixture(autouse=True, scope="session")
def nothing_waits_for_clocks_or_disks() -> Iterator[None]:
    """Studies measure their speed once, not three times, and files need not be safe.

    Both are no matter of what comes of a study, and a sixth of one of a small case.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(speed, "_TRIES", 1)
        patch.setattr(speed, "_CHUNKS", 1)
        patch.setattr(os, "fsync", lambda _: None)
        yield


@pytest.fixture(autouse=True)
def figures_stay_blank(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Figures are made and saved, but not drawn: half of the time of many a study.

    Slow tests draw them; files whose tests look at pictures have a fixture of the same
    name instead.
    """
    if request.node.get_closest_marker("slow") is None:
        monkeypatch.setattr(Figure, "draw", lambda figure, renderer: None)


@pytest.fixture(scope="session")
def vega_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """That `vega_verification` writes into."""
    return tmp_path_factory.mktemp("vega")


@pytest.fixture(scope="session")
def vega_verification(vega_folder: Path) -> Verification:
    """The main job, done once."""
    return verify("vega", output=vega_folder)


@pytest.fixture(scope="session")
def vega() -> Case:
    """The built-in case."""
    return load_case("vega")


@pytest.fixture(scope="session")
def vega_batch(vega: Case) -> Batch:
    """Shared for its programs, which take their time to compile."""
    limits = deviation_limits(vega.limits)
    return Batch(vega.separation, vega.box.names, deviation_limits=limits)


@pytest.fixture(scope="session")
def small_study(tmp_path_factory: pytest.TempPathFactory) -> tuple[Verification, Path]:
    """The main job on a case that takes a second, and the folder of its tables."""
    folder = tmp_path_factory.mktemp("small")
    case = write_case(folder, small_case())
    study = verify(case, samples=200, starts=3, seed=3, workers=1)
    with ResultsFolder(folder, "verify") as results:
        results.begin(study.asked)
        study.write_tables(results)
        results.end()
    return study, folder
