"""A script that is interrupted while a thread compiles ends in order, without it."""

import signal
import subprocess
import sys

import pytest


SCRIPT = """
import atexit, hashlib, os, signal, sys, threading
from drakesep.analysis.engines.jax.compiling_threads import compiling_threads

def deaf(rounds):  # as a compiler is
    hashlib.pbkdf2_hmac("sha256", b"", b"", rounds)
    print("over")

atexit.register(print, "in order")
pool = compiling_threads(1)
rounds, how = int(sys.argv[1]), sys.argv[2]
pool.submit(deaf, rounds)
if how == "another":
    threading.Thread(target=deaf, args=(rounds,)).start()
try:
    os.kill(os.getpid(), signal.SIGINT)
    threading.Event().wait()
except KeyboardInterrupt:
    if how == "caught":
        sys.exit(3)
    raise
finally:
    pool.shutdown(wait=False)
"""
LONG, SHORT = 100_000_000, 1_500_000
"""A minute, and longer than is waited for."""


@pytest.mark.parametrize(
    ("rounds", "how", "code", "said"),
    [
        (LONG, "uncaught", -signal.SIGINT, ["in order"]),
        (1, "uncaught", -signal.SIGINT, ["over", "in order"]),
        # Which code it ends with, nobody knows before its end.
        (SHORT, "caught", 3, ["over", "in order"]),
        # It may have something to finish that is not ours.
        (SHORT, "another", -signal.SIGINT, ["over", "over", "in order"]),
    ],
)
def test_who_waits_for_a_compiler(rounds, how, code, said):
    script = [sys.executable, "-c", SCRIPT, str(rounds), how]
    done = subprocess.run(script, capture_output=True, text=True, timeout=300)
    assert done.returncode == code, done.stderr
    assert done.stdout.split("\n")[:-1] == said
    assert done.stderr.endswith("KeyboardInterrupt\n") == (how != "caught")
    assert done.stderr.count("Traceback") == (how != "caught")
