"""Files of proven bounds."""

from drakesep.results.catalogue.columns import (
    BOUND,
    IDENTITY,
    LIMIT,
    LIMIT_KEY,
    SAME,
    UNIT,
)
from drakesep.results.catalogue.file_kind import Column, FileKind
from drakesep.results.catalogue.names import PROVEN


PROOF_FILES = (
    FileKind(
        name="proofs.csv",
        studies=PROVEN,
        what="Proven bounds beside the worst found and the limits, see worst_cases.md; "
        "what no bound covers, with the reason.",
        row="requirement and axis, then objective",
        key=(*LIMIT_KEY, "objective"),
        columns=(
            Column("requirement", "", "Its quantity; empty of an objective."),
            Column("axis", "", "Empty if it has none."),
            UNIT,
            Column("sense", "", "`<=` or `<`: it is bounded from above; else below."),
            Column("limit", SAME, "That is required; empty of an objective."),
            *LIMIT[5:],
            Column("objective", "", "Of a row that is of no requirement."),
            *BOUND,
            Column(
                "found",
                SAME,
                "The worst found: in runs within the tolerances, flown in Drake; in "
                "`prove`, what enclosures show to be attained, in inertias that no "
                "body can have, too.",
            ),
            Column("found_by", "", "Label of that run; or `enclosure`."),
            Column(
                "verdict",
                "",
                "`proven met`: the bound is within the limit; `not proven`; `not "
                "covered`: there is no bound; `bounded`: of an objective, there is; "
                "`contradicted`: a run is beyond the bound, and one of the two is "
                "wrong. Of a share of launches, too, it is over the tolerances, beyond "
                "which draws may be.",
            ),
            Column("reason", "", "Why no more is proven."),
            Column("claim", "", "Its name in proof.json."),
            Column("boxes", "", "That were enclosed for it."),
            *IDENTITY,
        ),
    ),
    FileKind(
        name="proof.json",
        studies=PROVEN,
        what="The certificate: the problem, and of each bound the tree of boxes that "
        "proves it, in the form that proof.md says; "
        "`drakesep check-proof proof.json` checks it.",
    ),
)
