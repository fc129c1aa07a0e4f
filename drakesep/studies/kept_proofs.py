"""Proofs that a study has finished, kept in its folder until it ends.

A study that goes on with one that ended early takes them from there: a bound that is
proven is not proven again.
"""

from collections.abc import Sequence
from dataclasses import replace

from drakesep.analysis.bounds.branch_and_bound import Proof
from drakesep.analysis.bounds.certificate import nodes_of
from drakesep.results.folder import ResultsFolder


class KeptProofs:
    """The proofs of a study, by the names of their claims.

    Attributes:
        known: those that are kept from before.
    """

    def __init__(self, folder: ResultsFolder | None, claims: Sequence[str]):
        """Read what is kept, if the study goes on with another.

        Args:
            folder: of the study; None: nothing is kept.
            claims: names of the claims, in the order of the study.

        Raises:
            ValueError: what is kept is no proof.
        """
        self._folder = folder
        # By their numbers: what a body is called need not be the name of a file.
        self._parts = {claim: f"proof_{i}" for i, claim in enumerate(claims)}
        self.known: dict[str, Proof] = {}
        if folder is None:
            return
        for claim, part in self._parts.items():
            if (kept := folder.part(part, Proof)) is not None:
                [self.known[claim]] = kept

    def keep(self, claim: str, proof: Proof) -> None:
        """Keep a proof that has been found.

        Args:
            claim: name of its claim.
            proof: of it.
        """
        if self._folder is not None:
            nodes = tuple(nodes_of(proof.tree))
            self._folder.keep_part(self._parts[claim], [replace(proof, tree=nodes)])
