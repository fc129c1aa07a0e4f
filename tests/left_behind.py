"""What a study leaves in its results folder, and a command of processes."""

import json
import subprocess
import time
from pathlib import Path


_OF_THE_RUN = ("begun", "seconds", "process")
"""In a record: when and in which process, which differ in equal studies."""


def whole(folder, *, but=()):
    """The record of a study and the bytes of its other files, but when it was made.

    Args:
        folder: of its results.
        but: more keys of the record that are left out.
    """
    files = {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }
    record = json.loads(files.pop("study.json"))
    for name in (*_OF_THE_RUN, *but):
        del record[name]
    return record, files


def descendants(pid):
    """Numbers of the processes that one has started, and those of theirs; their words.

    Args:
        pid: of a process that runs.
    """
    told = subprocess.run(
        ["ps", "-eo", "pid=,ppid=,args="], capture_output=True, text=True, check=True
    )
    rows = [line.split(None, 2) for line in told.stdout.splitlines()]
    found, parents = {}, {str(pid)}
    while parents:
        new = {child: words for child, parent, words in rows if parent in parents}
        parents = new.keys() - found.keys()
        found |= new
    return found


def semaphores(pid):
    """What a process keeps in shared memory; names on Linux begin so.

    Args:
        pid: of a process, which may have ended.
    """
    return [*Path("/dev/shm").glob(f"*-{pid}-*")]


def nothing_is_left(pid, theirs):
    """Within 30 s of its end.

    Args:
        pid: of a process that has ended.
        theirs: the processes that it had started.
    """
    ended = time.monotonic()
    while left := [*_running(theirs), *semaphores(pid)]:
        assert time.monotonic() - ended < 30.0, left
        time.sleep(0.1)


def _running(pids):
    told = subprocess.run(
        ["ps", "-o", "stat=,pid=,args=", "-p", ",".join(pids)],
        capture_output=True,
        text=True,
    )
    return [line for line in told.stdout.splitlines() if not line.startswith("Z")]
