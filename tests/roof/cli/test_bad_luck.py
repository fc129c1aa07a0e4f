"""What a command makes of signals, full disks and consoles, in its own process."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from left_behind import whole
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
    """In a destructor, where Python lets no exception out: the watch ends it."""
    script = (
        "import os, signal, time\n"
        "from drakesep.cli import signals\n"
        "signals.listen(); signals.command_begins('verify', as_json=False)\n"
        "class Careless:\n"
        "    def __del__(self): os.kill(os.getpid(), signal.SIGINT)\n"
        "careless = Careless(); del careless\n"
        "time.sleep(60); print('went on')\n"
    )
    process = begun(entry=(sys.executable, "-c", script))
    out, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert out == ""
    assert err.splitlines()[-1] == "drakesep: interrupted"


def test_a_signal_in_the_midst_of_a_study(tmp_path):
    process = begun("verify", "vega", "-o", tmp_path, "--search", "drake")
    while process.poll() is None and not (tmp_path / "study.json").exists():
        time.sleep(0.05)
    process.terminate()
    _, err = process.communicate(timeout=60)
    assert process.returncode == 143
    assert err.splitlines()[-1].startswith("drakesep: terminated")
    # In order, or in the midst of a minute within a compiler: never half.
    assert json.loads((tmp_path / "study.json").read_text())["study"] == "verify"


def test_a_reader_who_has_seen_enough():
    with begun("show", "vega") as process:
        process.stdout.close()
        assert process.stderr.read() == ""
    assert process.returncode == 0


def test_a_console_that_cannot_show_a_character():
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    process = begun("show", "vega", env=environment)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert "kg" in out and out.isascii()


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


def beside(process):
    """Numbers of the processes that a command has started, and theirs; their words."""
    told = subprocess.run(
        ["ps", "-eo", "pid=,ppid=,args="], capture_output=True, text=True, check=True
    )
    rows = [line.split(None, 2) for line in told.stdout.splitlines()]
    found, parents = {}, {str(process.pid)}
    while parents:
        new = {pid: words for pid, parent, words in rows if parent in parents}
        parents = new.keys() - found.keys()
        found |= new
    return found


def under_way(tmp_path):
    """A study that has begun, with a worker beside it."""
    process = begun("verify", "vega", "-o", tmp_path, "--workers", "2")
    while process.poll() is None and not (tmp_path / "study.json").exists():
        time.sleep(0.05)
    assert process.poll() is None
    return process


@pytest.mark.slow
def test_nothing_is_left_of_what_is_killed(tmp_path):
    with under_way(tmp_path) as process:
        others = beside(process)
        process.kill()
    assert others
    killed = time.monotonic()
    while left := {pid for pid in others if os.path.exists(f"/proc/{pid}")}:
        assert time.monotonic() - killed < 30.0, left
        time.sleep(0.2)


@pytest.mark.slow
def test_a_worker_that_is_killed(tmp_path):
    """Is told of in one line; what is finished is kept."""
    with under_way(tmp_path) as process:
        workers = [
            int(pid) for pid, words in beside(process).items() if "popen" in words
        ]
        os.kill(workers[-1], signal.SIGKILL)
        _, err = process.communicate(timeout=300)
    assert process.returncode == 3
    [line] = [x for x in err.splitlines() if x.startswith("drakesep: ")]
    assert line == "drakesep: a process of ours was killed, for want of memory perhaps"
    assert "Traceback" not in err
    assert json.loads((tmp_path / "study.json").read_text())["ended"] == "failed"
    assert (tmp_path / ".parts").is_dir()


@pytest.mark.slow
def test_two_commands_want_a_folder(tmp_path):
    both = [begun("simulate", "vega", "-o", tmp_path) for _ in range(2)]
    told = [process.communicate(timeout=120)[1] for process in both]
    codes = [process.returncode for process in both]
    assert sorted(codes) in ([0, 2], [0, 0])  # one after the other
    for code, err in zip(codes, told, strict=True):
        assert (code == 2) == ("no other study is writing" in err)
