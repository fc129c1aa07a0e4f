"""What a command makes of signals, full disks and consoles, in its own process."""

import json
import os
import random
import signal
import subprocess
import sys
import time

import pytest
from left_behind import descendants, nothing_is_left, semaphores, whole
from small_case import small_case, write_case


ENTRY = (sys.executable, "-c", "from drakesep.cli.entry import main; main()")
IMPORTS = (sys.executable, "-X", "importtime", *ENTRY[1:])
CODES = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129}
WORDS = {130: "interrupted", 143: "terminated", 129: "hung up"}


LAUNCH = """
import os, resource, signal, sys
for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
    signal.signal(number, signal.SIG_DFL)
if int(sys.argv[1]):
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]),) * 2)
os.execv(sys.argv[2], sys.argv[2:])
"""
"""A test run in the background inherits that signals are ignored. Said by a program of
its own, since a test must not fork where JAX has threads."""


def begun(*words, entry=ENTRY, largest_file=0, **how):
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    command = [sys.executable, "-c", LAUNCH, largest_file, *entry, *words]
    return subprocess.Popen([*map(str, command)], **{**pipes, **how})


def imported(process, module):
    """Wait until a module has been imported; Python tells it of each."""
    for line in process.stderr:
        if line.rstrip().endswith(f" {module}"):
            return


@pytest.mark.parametrize("number", CODES)
@pytest.mark.parametrize("module", ["typer", "pydantic", "numpy", "jax", "pydrake"])
def test_signals_as_it_imports(number, module, tmp_path):
    """Nothing is begun yet: it ends at once, and says so to both kinds of readers."""
    words = ("verify", "vega", "-o", tmp_path / "out", "--json")
    process = begun(*words, entry=IMPORTS)
    imported(process, module)
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    code = CODES[number]
    assert process.returncode == code
    lines = [line for line in err.splitlines() if line.startswith("drakesep: ")]
    assert lines == [f"drakesep: {WORDS[code]}"]
    told = json.loads(out)
    assert (told["format"], told["exit_code"], told["error"]) == (1, code, WORDS[code])


def test_a_signal_that_is_lost():
    """In a destructor, where Python lets no exception out: it is raised again."""
    script = (
        "import os, signal, time\n"
        "from drakesep.cli import signals\n"
        "signals.listen(); signals.command_begins('verify', as_json=False)\n"
        "class Careless:\n"
        "    def __del__(self): os.kill(os.getpid(), signal.SIGINT)\n"
        "try:\n"
        "    careless = Careless(); del careless\n"
        "    time.sleep(60)\n"
        "except KeyboardInterrupt: print('in order', flush=True)\n"
        "time.sleep(60)\n"  # the watch ends what does not end by itself
    )
    process = begun(entry=(sys.executable, "-c", script))
    out, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert out == "in order\n"
    assert err == "drakesep: interrupted\n"


def test_a_signal_in_the_midst_of_a_study(tmp_path):
    process = begun("verify", "vega", "-o", tmp_path, "--search", "drake")
    while process.poll() is None and not (tmp_path / "study.json").exists():
        time.sleep(0.05)
    process.terminate()
    _, err = process.communicate(timeout=60)
    assert process.returncode == 143
    assert err.splitlines()[-1].startswith("drakesep: terminated")
    # In order, or in the midst of a minute within a compiler: never half.
    record = json.loads((tmp_path / "study.json").read_text())
    assert (record["study"], record["ended"]) == ("verify", "interrupted")


SIZE = ("campaign", "size", "--share", "0.9")
SAYS = [SIZE, (*SIZE, "--json"), ("--help",), ("--version",)]
"""Ways to write on standard output: by tables, at once, or without a command."""
said = pytest.mark.parametrize("words", SAYS, ids=" ".join)
BUFFERED = {k: v for k, v in os.environ.items() if k != "PYTHONUNBUFFERED"}
"""As Python is, unless it is told otherwise."""


@said
def test_a_reader_who_has_seen_enough(words):
    with begun(*words, env=BUFFERED) as process:
        process.stdout.close()
        assert process.stderr.read() == ""
    assert process.returncode == 0


@said
def test_standard_output_on_a_full_disk(words):
    with (
        open("/dev/full", "w") as full,
        begun(*words, stdout=full, env=BUFFERED) as process,
    ):
        why = "drakesep: standard output: No space left on device\n"
        assert process.stderr.read() == why
    assert process.returncode == 3


CLOSED = """
import os, sys
for number in map(int, sys.argv[1].split()):
    os.close(number)
script = "import sys; from drakesep.cli import signals, streams\\n"
script += "streams.prepare(); signals.listen(); file = open(sys.argv[1], 'w')\\n"
script += "print('out', flush=True); print('err', file=sys.stderr); sys.stdin.read()"
os.execv(sys.executable, [sys.executable, "-c", script, sys.argv[2]])
"""


@pytest.mark.parametrize("closed", ["0", "1", "2", "0 1 2"])
def test_closed_streams(closed, tmp_path):
    """No file of a study's takes the place of one, and is written into."""
    entry = (sys.executable, "-c", CLOSED, closed, tmp_path / "file")
    process = begun(entry=entry, stdin=subprocess.DEVNULL)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert out == ("" if "1" in closed else "out\n")
    assert err == ("" if "2" in closed else "err\n")
    assert (tmp_path / "file").read_text() == ""


def test_a_terminal_that_is_gone():
    """What is said aside is lost, and nothing else is."""
    script = "import sys; from drakesep.cli import streams; streams.prepare()\n"
    script += "print('err', file=sys.stderr, flush=True); print('out')"
    with open("/dev/full", "w") as gone:  # as wrong to write on
        process = begun(entry=(sys.executable, "-c", script), stderr=gone, env=BUFFERED)
        out, _ = process.communicate(timeout=60)
    assert (process.returncode, out) == (0, "out\n")


def test_words_that_make_no_sense():
    """One line, as of other mistakes."""
    process = begun("simulate", "vega", "--sampels", "3")
    out, err = process.communicate(timeout=60)
    assert process.returncode == 2
    assert out == ""
    [line] = err.splitlines()
    assert line.startswith("drakesep: No such option: --sampels")
    assert line.endswith("simulate --help`)")


def test_a_console_that_cannot_show_a_character():
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    process = begun("show", "vega", env=environment)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert "kg" in out and out.isascii()


@pytest.mark.slow
@pytest.mark.parametrize("command", ["simulate", "verify"])
def test_caches_that_cannot_be_written(command, tmp_path):
    """What is drawn needs one, silently; compiled programs are told of in a line."""
    case = write_case(tmp_path, small_case())
    homes = {"HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "MPLCONFIGDIR"}
    environment = {k: v for k, v in os.environ.items() if k not in homes}
    environment |= {"HOME": "/proc/nowhere", "TMPDIR": str(tmp_path)}
    words = ("--samples", 20, "--starts", 2) if command == "verify" else ()

    process = begun(command, case, *words, "-o", tmp_path / "out", env=environment)
    _, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    progress = (" left: ", "Worst cases of ")
    told = [x for x in err.splitlines() if not any(said in x for said in progress)]
    kept = "drakesep: warning: /proc/nowhere/.cache/drakesep/jax: No such file or "
    kept += "directory: programs are not kept, and compiled anew by each process"
    assert told == ([kept] if command == "verify" else [])
    assert list((tmp_path / "out").rglob("*.png"))
    assert {file.name for file in tmp_path.iterdir()} == {case.name, "out"}


@pytest.mark.parametrize("command", ["simulate", "sweep"])
def test_a_full_disk_names_the_file(command, tmp_path):
    """A limit on the size of files is what a full disk is: some are written."""
    case = write_case(tmp_path, small_case())
    words = ["upper.mass_kg=1180:1220:40"] if command == "sweep" else []

    process = begun(command, case, *words, "-o", tmp_path / "out", largest_file=12_000)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 3, err
    [line] = [x for x in err.splitlines() if x.startswith("drakesep: ")]
    assert line.startswith(f"drakesep: {tmp_path / 'out'}")
    assert line.endswith(": File too large")
    assert not list((tmp_path / "out").rglob(".writing-*"))


@pytest.mark.slow
def test_a_study_that_is_killed_goes_on(tmp_path):
    """After each search; with a clearance, which is searched beside the others."""
    clearance = {"quantity": "clearance_mm", "at_least": 20.0}
    required = [*small_case()["requirements"][:1], clearance]
    case = write_case(tmp_path, small_case(requirements=required))
    words = ["--samples", 60, "--starts", 3, "--seed", 2]

    def asked(folder, *more):
        return begun("verify", case, "-o", folder, *words, *more)

    with asked(tmp_path / "whole") as process:
        process.communicate(timeout=300)
    folder, killed = tmp_path / "killed", 0
    for part in ("plan", "samples", "vertices", "sqp", "multistart", "growth"):
        with asked(folder, "--resume") as process:
            while (
                process.poll() is None and not (folder / f".parts/{part}.json").exists()
            ):
                time.sleep(0.01)
            process.kill()
            process.communicate()
        killed += process.returncode == -signal.SIGKILL
    assert killed >= 3  # the last parts are finished quickly
    with asked(folder, "--resume") as process:
        _, err = process.communicate(timeout=300)
    assert whole(folder, but=["again"]) == whole(tmp_path / "whole", but=["again"]), err


def begun_apart(*words, until, **how):
    """A command in a session of its own that has come so far; and what it started."""
    process = begun(*words, start_new_session=True, **how)
    while process.poll() is None and not until():
        time.sleep(0.05)
    assert process.poll() is None
    return process, descendants(process.pid)


def verifies(tmp_path):
    """A study that has begun, with a worker beside it."""
    words = ("verify", "vega", "-o", tmp_path, "--workers", "2")
    return begun_apart(*words, until=(tmp_path / "study.json").exists)


POOL = """
import sys, pathlib
from drakesep.analysis.engines.drake_pool import DrakePool
import drakesep
case = drakesep.load_case("vega").in_si()
with DrakePool(case.separation, workers=2) as pool:
    said = lambda *_: pathlib.Path(sys.argv[1]).touch()
    pool.fly([{"payload.mass": 2000.0 + i} for i in range(100_000)], said)
"""


def flies_a_campaign(tmp_path):
    case = write_case(tmp_path, small_case())
    words = ("campaign", case, "--workers", 2, "--runs", 1_000_000)
    chunks = (tmp_path / "out").glob
    return begun_apart(
        *words, "-o", tmp_path / "out", until=lambda: any(chunks(".parts/chunk*"))
    )


def flies_in_drake(tmp_path):
    entry = (sys.executable, "-c", POOL)
    flown = tmp_path / "flown"
    return begun_apart(flown, entry=entry, until=flown.exists)


@pytest.mark.slow
@pytest.mark.parametrize("command", [verifies, flies_a_campaign, flies_in_drake])
@pytest.mark.parametrize("kill", [os.kill, os.killpg], ids=["one", "group"])
def test_nothing_is_left_of_what_is_killed(kill, command, tmp_path):
    """Though what clears away may have been in the group that was killed."""
    process, theirs = command(tmp_path)
    with process:
        assert len(theirs) >= 3  # workers and trackers
        assert semaphores(process.pid)
        kill(process.pid, signal.SIGKILL)
    nothing_is_left(process.pid, theirs)


@pytest.fixture(scope="module")
def a_study(tmp_path_factory):
    """A study from imports to plots; and how long it takes, s."""
    folder = tmp_path_factory.mktemp("study")
    case = write_case(folder, small_case())
    words = ("verify", case, "--samples", 60, "--starts", 3, "--workers", 2)
    for _ in range(2):  # first, programs are compiled
        began = time.monotonic()
        with begun(*words, "-o", folder / "out") as process:
            process.communicate(timeout=300)
        assert process.returncode in (0, 1)
    return words, time.monotonic() - began


@pytest.mark.slow
@pytest.mark.parametrize("to_all", [True, False], ids=["all", "one"])
@pytest.mark.parametrize(
    ("number", "moments"),
    [(signal.SIGINT, 20), (signal.SIGTERM, 6), (signal.SIGHUP, 6)],
)
def test_a_signal_at_any_moment(number, moments, to_all, a_study, tmp_path):
    """To all processes of a command, as a terminal does, or to the command alone."""
    words, seconds = a_study
    code, heard = CODES[number], 0
    for i in range(moments):
        moment = (i + random.random()) / moments * seconds
        folder = tmp_path / str(i)
        process = begun(*words, "-o", folder, start_new_session=True)
        time.sleep(moment)
        over = process.poll() is not None  # it was faster
        theirs = descendants(process.pid)
        sent = time.monotonic()
        if not over:
            (os.killpg if to_all else os.kill)(process.pid, number)
            process.wait(timeout=60)
        took = time.monotonic() - sent
        _, err = process.communicate()
        told = f"at {moment:.2f} s of {seconds:.2f} s, in {took:.2f} s: {err}"
        assert took < 3.0, told  # 2 s are promised; a busy machine has one more
        assert "Traceback" not in err or moment < 1.0, told  # Python itself begins
        record = folder / "study.json"
        ended = json.loads(record.read_text())["ended"] if record.exists() else None
        if process.returncode in (0, 1):  # it had said so before
            assert ended == "completed", told
        elif process.returncode == -number:  # Python's, until we listen
            assert ended is None and moment < 1.0, told
        else:
            assert process.returncode == code, told
            heard += 1
            assert f"drakesep: {WORDS[code]}" in err, told
            # What is completed may be being told of.
            assert ended in (None, "interrupted", "completed"), told
            assert not (folder / ".drakesep.lock").exists(), told
        nothing_is_left(process.pid, theirs)
    assert heard > moments // 3


@pytest.mark.slow
def test_a_worker_that_is_killed(tmp_path):
    """Is told of in one line; what is finished is kept."""
    process, theirs = verifies(tmp_path)
    workers = [int(pid) for pid, words in theirs.items() if "popen" in words]
    with process:
        os.kill(workers[-1], signal.SIGKILL)
        _, err = process.communicate(timeout=300)
    assert process.returncode == 3
    [line] = [x for x in err.splitlines() if x.startswith("drakesep: ")]
    assert line == "drakesep: a process of ours was killed, for want of memory perhaps"
    assert "Traceback" not in err
    assert json.loads((tmp_path / "study.json").read_text())["ended"] == "failed"
    assert (tmp_path / ".parts").is_dir()
    nothing_is_left(process.pid, theirs)


@pytest.mark.slow
def test_two_commands_want_a_folder(tmp_path):
    both = [begun("simulate", "vega", "-o", tmp_path) for _ in range(2)]
    told = [process.communicate(timeout=120)[1] for process in both]
    codes = [process.returncode for process in both]
    assert sorted(codes) in ([0, 2], [0, 0])  # one after the other
    for code, err in zip(codes, told, strict=True):
        assert (code == 2) == ("no other study is writing" in err)
