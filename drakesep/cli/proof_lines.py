"""What the command line prints of what is proven."""

import math

import pandas as pd
from rich.console import Console

from drakesep.analysis.bounds.answers import BOUNDED, NOT_COVERED, PROVEN_MET
from drakesep.cli.console import print_frame
from drakesep.cli.requirement_lines import requirement_names_and_limits
from drakesep.studies.proofs import Proofs


def print_proofs(console: Console, study: Proofs) -> None:
    """Print bounds beside the worst found, and what no bound covers."""
    if study.why_nothing:
        words = f"Nothing is proven of {study.case.name}: {study.why_nothing}."
        console.print(words, markup=False)
        return
    frame = study.table
    bodies = [pair.B for pair in study.case.separation.pairs]
    told = requirement_names_and_limits(frame, bodies)
    asked = zip(told["requirement"], frame["objective"], strict=True)
    names = [name or other for name, other in asked]
    of_objective = frame["requirement"] == ""
    lines = pd.DataFrame(
        {
            "requirement or objective": names,
            "limit": [
                unit if alone else limit
                for limit, unit, alone in zip(
                    told["limit"], frame["unit"], of_objective, strict=True
                )
            ],
            "found": frame["found"],
            "proven bound": frame["proven_bound"],
            "gap %": frame["gap_percent"].map(_percent),
            "proven": frame["verdict"],
        }
    )
    title = "Proven bounds, beside the worst found"
    covered = frame["verdict"] != NOT_COVERED
    print_frame(console, title, lines[covered], whole=True)
    for name, verdict, reason in zip(
        names, frame["verdict"], frame["reason"], strict=True
    ):
        if verdict not in (PROVEN_MET, BOUNDED):
            words = f"{verdict.capitalize()}: {name}: {reason}."
            console.print(words, markup=False)
    console.print(
        "No run within the tolerances is beyond a proven bound: at any corner and "
        "anywhere between, in inertias that no body can have, too."
    )


def _percent(gap: float) -> str:
    return "" if math.isnan(gap) else f"{gap:.2f}"


def print_proven(console: Console, study: Proofs) -> None:
    """Print whether it is proven that every requirement is met."""
    if study.why_nothing or study.verdict is None:
        return
    answers = study.by_requirement.values()
    if study.verdict == PROVEN_MET:
        console.print("[bold green]Every requirement is proven to be met.[/]")
        return
    met = sum(one.verdict == PROVEN_MET for one in answers)
    console.print(
        f"[bold]It is proven of {met} of {len(answers)} requirements that they are "
        "met.[/]"
    )
