"""A command in a process that another program watches: warm, and told as it goes on.

``python -m drakesep.cli.watched`` imports what studies need, and then does what lines
of JSON on standard input ask of it:

- ``{"warm": {"case": TEXT, "folder": DIR, "objectives": [...], "verifies": false}}``
  makes what takes long in a study of a case, any number of times; what is asked after
  it takes the place of one that waits;
- ``{"run": [...], "folder": DIR}`` runs a command as `drakesep` does with these
  arguments in that folder; the process ends with it, and exits as it does;
- ``{"stop": true}``, or the end of the input as its program ends, leaves results in
  order, to be resumed, and ends the process at once, whatever it is at.

Each line on standard output is an event as JSON, whose ``event`` says of what: `ready`
and `warm` (with the ``error`` of a case that cannot be studied), `progress`, `iterate`
(a row of `iterates.csv`; it ``falls`` if its value is the worse the less it is),
`draws` (what a campaign's draws show so far), and at last `ended`, with the
``exit_code`` and the ``summary`` that `--json` prints. A command that was stopped has
not ended: the process exits with 130, and that says it.
"""

import contextlib
import io
import json
import os
import queue
import sys
import threading
import time
from pathlib import Path
from typing import Any

from drakesep.cli import signals


_PACE = 0.1
"""Between two tellings of the same step, s."""


def main() -> None:
    """Do what is asked, until a command has been run."""
    out = os.dup(1)
    os.dup2(2, 1)  # what libraries print is no event
    events = _Events(out)
    signals.listen()
    asked: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(asked,), daemon=True).start()
    _import()
    events.tell("ready", process=os.getpid())
    while True:
        request = asked.get()
        if "warm" in request:
            if asked.empty():  # else it is not wanted any more
                events.tell("warm", error=_warmed(**request["warm"]))
        else:
            os.chdir(request["folder"])
            sys.exit(_run(request["run"], events))


def _listen(asked: "queue.SimpleQueue[dict[str, Any]]") -> None:
    """Hear what is asked, also while something is being done."""
    for line in sys.stdin:
        request = json.loads(line)
        if "stop" in request:
            break
        asked.put(request)
    signals.end_now(signals.INTERRUPTED)


def _import() -> None:
    """Import what commands import when they are run."""
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
    from drakesep.cli import app, progress, results, summaries  # noqa: F401
    from drakesep.plots import clearance_plots, motion, tornado  # noqa: F401
    from drakesep.studies import verification  # noqa: F401
    from drakesep.studies.campaign import procedure  # noqa: F401


def _warmed(
    case: str, folder: str, objectives: list[str], verifies: bool
) -> str | None:
    """Warm up for a case; return what is wrong with it, None if nothing is."""
    from drakesep.case_file.reader import read_case
    from drakesep.studies.warm import warm_up

    try:
        read = read_case(case, folder=Path(folder))
        warm_up(read, objectives or None, verifies=verifies)
    except (ValueError, RuntimeError) as error:
        return str(error)
    return None


def _run(arguments: list[str], events: "_Events") -> int:
    """Run a command; tell what it does, and return its exit code."""
    from drakesep.cli.app import main as command_line
    from drakesep.cli.progress import tell_also
    from drakesep.cli.told import Told

    tell_also(Told(events.tell))
    sys.argv = ["drakesep", *arguments]
    code, said = 0, io.StringIO()
    with contextlib.redirect_stdout(said):
        try:
            command_line()
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 1
    if code == signals.INTERRUPTED:
        return code
    try:
        summary = json.loads(said.getvalue())
    except ValueError:  # of a command that has no summary
        summary = {}
    events.tell("ended", exit_code=code, summary=summary)
    return code


class _Events:
    """Writes events, each a line; those of a step at a pace that a page can bear."""

    def __init__(self, out: int):
        self._out = out
        self._last = ("", 0.0)

    def tell(self, event: str, **what: Any) -> None:
        """Write an event, unless one of the same step has just been."""
        if event == "progress":
            step, now = what["step"], time.monotonic()
            if step == self._last[0] and now < self._last[1] + _PACE:
                return
            self._last = step, now
        line = json.dumps({"event": event, **what}, allow_nan=False) + "\n"
        rest = line.encode()
        while rest:
            rest = rest[os.write(self._out, rest) :]


if __name__ == "__main__":
    main()
