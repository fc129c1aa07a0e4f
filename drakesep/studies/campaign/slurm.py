"""A campaign as an array of Slurm jobs."""

import shlex
from pathlib import Path

from drakesep.results.campaign_files import RecordedPlan
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError


@typed
def array_script(directory: str | Path, tasks: int) -> str:
    """Return a script that flies the chunks of a planned campaign as a Slurm array.

    Args:
        directory: of the campaign, which every node must see.
        tasks: of the array at most; each flies its share of the chunks.

    Raises:
        ValueError: there is no such plan, or no task.
    """
    if tasks < 1:
        raise InputError(f"tasks: must be 1 or more, got {tasks}")
    folder = Path(directory).absolute()
    plan = RecordedPlan.read(folder).plan
    count = min(tasks, plan.chunks)
    where = shlex.quote(str(folder))
    return f"""#!/bin/bash
#SBATCH --job-name={_name(plan.case.name)}
#SBATCH --array=0-{count - 1}
#SBATCH --cpus-per-task=2
# {plan.runs} draws in {plan.chunks} chunks. A task that fails leaves no half chunk:
# submit the script again, and what is there stays. When all tasks have ended,
#     drakesep campaign merge {where}
# tells what came of them, or which chunks are missing (exit code 4).
set -e
numbers=$(seq "$SLURM_ARRAY_TASK_ID" {count} {plan.chunks - 1})
drakesep campaign run-chunk {where} $numbers --quiet
"""


def _name(case: str) -> str:
    """Return a name that stands in a script: a case may be named anything."""
    return "".join(x if x.isalnum() or x in "-_" else "_" for x in case)
