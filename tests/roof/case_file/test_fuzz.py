"""Nearly right case files: read, shown and flown, or refused in words of ours.

A few hundred of them, the same ones each time; many more, drawn anew, behind `fuzz`.
"""

import contextlib
import io
import math
import time
import warnings

import numpy as np
import pytest
from every_leaf import write_models
from hypothesis import HealthCheck, Phase, event, given, settings
from mutations import as_text, mangled, mutated
from rich.console import Console

from drakesep.case_file.reader import load_case
from drakesep.cli.console import print_case, print_notes
from drakesep.cli.summaries import of_case
from drakesep.studies.before_flight import check_verifiable
from drakesep.studies.simulate import simulate
from drakesep.systems.checks import DrakesepWarning, InputError


LONGEST = 10.0
"""Of the processor's time that a file takes to be read and shown, or flown, s."""


@contextlib.contextmanager
def ours():
    """Nothing comes out but a refusal in one line for each mistake, and soon."""
    began = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DrakesepWarning)
        try:
            yield
        except InputError as refused:
            event("refused")
            lines = str(refused).splitlines()
            assert lines and all(lines)
            assert "Error" not in str(refused)
    assert time.process_time() - began < LONGEST


def shown(file):
    """What `drakesep show` does, without its process."""
    case = load_case(file)
    told = io.StringIO()
    print_case(Console(file=told), case)
    of_case(case)
    print_notes(Console(file=told), check_verifiable(case))
    event("shown")
    return case


def check_read(text, folder):
    file = folder / "case.yaml"
    file.write_text(text, encoding="utf-8", errors="surrogatepass")
    with ours():
        shown(file)


def check_flown(text, folder):
    """A run fails with its reason, or each number of it is one."""
    file = folder / "case.yaml"
    file.write_text(text, encoding="utf-8", errors="surrogatepass")
    with ours():
        flown = simulate(load_case(file))
        event("flown" if flown.completed else "failed")
        if not flown.completed:
            assert flown.labelled.outcome.message
            return
        states = flown.run.completed_trajectory.states
        assert np.isfinite(states).all()
        assert not any(map(math.isinf, flown.labelled.metrics.values()))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With the files that cases name."""
    folder = tmp_path_factory.mktemp("fuzz")
    write_models(folder)
    return folder


SLOW = [HealthCheck.too_slow]
"""Some fly for seconds."""
few = settings(max_examples=60, derandomize=True, suppress_health_check=SLOW)
fewer = settings(few, max_examples=25)
UNSHRUNK = [Phase.explicit, Phase.reuse, Phase.generate]
"""To shrink what takes ten seconds to fail takes hours."""
many = settings(max_examples=5000, phases=UNSHRUNK, suppress_health_check=SLOW)


@few
@given(data=mutated())
def test_a_few_are_read_or_refused(data, folder):
    check_read(as_text(data), folder)


@few
@given(text=mangled())
def test_a_few_texts_are_read_or_refused(text, folder):
    check_read(text, folder)


@fewer
@given(data=mutated())
def test_a_few_are_flown_or_refused(data, folder):
    check_flown(as_text(data), folder)


@pytest.mark.fuzz
@many
@given(data=mutated())
def test_many_are_read_or_refused(data, folder):
    check_read(as_text(data), folder)


@pytest.mark.fuzz
@many
@given(text=mangled())
def test_many_texts_are_read_or_refused(text, folder):
    check_read(text, folder)


@pytest.mark.fuzz
@settings(many, max_examples=1000)
@given(data=mutated())
def test_many_are_flown_or_refused(data, folder):
    check_flown(as_text(data), folder)
