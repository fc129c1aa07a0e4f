"""The compliance matrix: each requirement with all that studies say of it."""

import operator
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from drakesep.analysis.bounds.answers import PROVEN_MET
from drakesep.analysis.metrics.requirements import Verdict
from drakesep.plots.limits import SIGNS
from drakesep.reports.cells import EMPTY, Cell, Row
from drakesep.reports.deciding import Deciding, deciding_of, disproves
from drakesep.reports.studies import Studies
from drakesep.tables.roles import Worst, label_of


MET, NOT_MET = Verdict.MET.value, Verdict.NOT_MET.value
NOT_LOOKED_AT = Verdict.NOT_LOOKED_AT.value
NOT_SHOWN = "not shown"
NO_VERDICT = "no verdict"
_SEARCHED, _PROVEN, _DRAWN, _FLOWN = (
    "worst case searched",
    "bound proven over the tolerances",
    "campaign of draws",
    "single run, which gives no verdict",
)

_BEYOND: Mapping[str, Callable[[float, float], bool]] = {
    SIGNS["<="]: operator.gt,
    SIGNS[">="]: operator.lt,
    SIGNS["<"]: operator.ge,
    SIGNS[">"]: operator.le,
}
"""When a value does not keep a limit, by its sense as rows have it."""

_Key: TypeAlias = tuple[Any, ...]


@dataclass(frozen=True, kw_only=True)
class Entry:
    """A requirement, and what studies say of it; rows that there are not are empty."""

    searched: Row | None = None
    """Of requirements.csv."""
    drawn: Row | None = None
    """Of campaign.csv."""
    flown: Row | None = None
    """Of requirements_of_run.csv."""
    beside: Row | None = None
    """Of answers.csv, which holds searches and draws against each other."""
    proof: Row | None = None
    """Of proofs.csv."""
    evidence: Row | None = None
    """Of evidence.csv, for the worst that was found."""
    unconfirmed: str = ""
    """How the worst run ended, if it was not confirmed."""

    @property
    def asked(self) -> Row:
        """The row that says what is required."""
        found = self.searched or self.drawn or self.flown or self.proof
        assert found is not None
        return found

    @property
    def share(self) -> Cell:
        """Of launches that must be within the limit; empty: every run must."""
        return self.asked["share"]

    @property
    def methods(self) -> list[str]:
        """How it was looked at."""
        told = []
        if self.searched and not self.share:
            told.append(_SEARCHED)
        if self.proven_bound:
            told.append(_PROVEN)
        if self.drawn:
            told.append(_DRAWN)
        return told or [_FLOWN if self.flown else NOT_LOOKED_AT]

    @property
    def nominal(self) -> Cell:
        """In the nominal run, or in the one that was flown."""
        if self.searched and self.searched["nominal"]:
            return self.searched["nominal"]
        return self.flown["value"] if self.flown else EMPTY

    @property
    def nominal_is_beyond(self) -> bool:
        """Whether the nominal run does not keep the limit."""
        if not (self.searched and self.searched["nominal"]):
            return False
        beyond = _BEYOND[str(self.searched.get("sense"))]
        return bool(beyond(self.searched.get("nominal"), self.searched.get("limit")))

    @property
    def is_unsampled(self) -> bool:
        """Whether neither random samples nor draws speak for the worst found."""
        sampled = self.evidence is None or self.evidence.get("random_samples", 0) > 0
        return not (sampled or self.drawn)

    @property
    def worst(self) -> Cell:
        """The worst that searches have found, in a run in Drake."""
        if self.searched and self.searched["worst"]:
            return self.searched["worst"].told_from(self.asked["limit"])
        return EMPTY

    @property
    def worst_draw(self) -> Cell:
        """The worst of all draws."""
        if self.drawn:
            return self.drawn["worst"].told_from(self.asked["limit"])
        return EMPTY

    @property
    def bound(self) -> Cell:
        """The statistical bound."""
        return self.drawn["bound"] if self.drawn else EMPTY

    @property
    def proven_bound(self) -> Cell:
        """No run within the tolerances is worse than it, as is proven."""
        return self.proof["proven_bound"] if self.proof else EMPTY

    @property
    def proven(self) -> Cell:
        """The verdict of that bound."""
        return self.proof["verdict"] if self.proof else EMPTY

    @property
    def gap(self) -> Cell:
        """Between the worst that was found and that bound, per cent of the former."""
        return self.proof["gap_percent"] if self.proof else EMPTY

    @property
    def deciding(self) -> Deciding:
        """The value of which the margin is, and why."""
        return deciding_of(self.searched, self.drawn, self.flown, self.share)

    @property
    def growth(self) -> Cell:
        """The factor on all tolerances at which it is violated."""
        return self.searched["growth_factor"] if self.searched else EMPTY

    @property
    def grows_beyond(self) -> Cell:
        """The largest factor that was looked at, if it was not violated up to that."""
        infinite = self.growth.value == float("inf")
        return self.searched["looked_up_to"] if self.searched and infinite else EMPTY

    @property
    def verdict(self) -> Cell:
        """On it, by the study that has to tell; a violation stands whoever tells it.

        A single run gives no verdict. What is proven for every run is met, if nothing
        else tells; it never mends what is not.
        """
        rows = [row for row in (self.searched, self.drawn) if row]
        if self.searched and self.searched.get("verdict") == NOT_MET:
            return self.searched["verdict"]
        if self.drawn and disproves(self.drawn, self.share):
            return self.drawn["verdict"]
        told = [
            row["verdict"] for row in rows if row["share"].value == self.share.value
        ]
        for word in (MET, NOT_SHOWN):
            for cell in told:
                if cell.value == word:
                    return cell
        if not told and not self.share and self.proven.value == PROVEN_MET:
            return Cell(MET)
        return told[0] if told else Cell(NOT_LOOKED_AT)

    @property
    def share_apart(self) -> Cell:
        """What a campaign says of a share that the case does not ask for."""
        apart = self.drawn and self.drawn["share"].value != self.share.value
        return self.drawn["verdict"] if self.drawn and apart else EMPTY

    @property
    def open_points(self) -> list[str]:
        """What is still to be done, or to be known of how it was looked at."""
        return list(_open_points(self))


def _open_points(entry: Entry) -> Iterator[str]:
    searched, drawn = entry.searched, entry.drawn
    if entry.unconfirmed:
        yield f"the worst run is not confirmed: {entry.unconfirmed}"
    if entry.nominal_is_beyond:
        yield "the nominal run is beyond the limit, whatever the tolerances"
    if entry.is_unsampled:
        yield "neither random samples nor draws speak for the worst found"
    if entry.beside and entry.beside["missed_draw"]:
        yield "a draw within the tolerances is worse than the worst that was found"
    if entry.share and drawn is None:
        yield "what is required of a share of launches is for a campaign to show"
    if not entry.share and searched is None and entry.proven.value != PROVEN_MET:
        yield "the worst case over the tolerances has not been searched"
    if searched and not entry.share:
        if searched.get("verdict") == NOT_LOOKED_AT:
            yield "no run tells it, or the one that does is not confirmed"
        how = searched.get("growth_by", "")
        if how == "ray":
            yield "growth: looked at on the way to the worst case alone"
        elif how != "search":
            yield f"growth: {how}"
    if _is_beyond_proven(entry):
        yield (
            f"the worst, in {entry.asked['which_run'].text}, is beyond the tolerances "
            "over which is proven"
        )
    if entry.proof and entry.proof.get("verdict") != PROVEN_MET:
        yield f"{entry.proven.text}: {entry.proof.get('reason', '')}"
    if drawn and drawn.get("failed", 0):
        yield "draws failed, which count as beyond the limit"
    if drawn and entry.share and drawn.get("verdict") == NOT_SHOWN:
        yield "too few draws to show the share, or that it is not kept"
    if drawn and entry.share and drawn.get("verdict") == NOT_LOOKED_AT:
        yield "no draw tells it, or Drake does not confirm those that do"


def _is_beyond_proven(entry: Entry) -> bool:
    """Return whether a published run is beyond a bound: it is beyond tolerances, too.

    Any other is beyond no bound, or contradicts it, which its verdict says.
    """
    if not (entry.searched and entry.proof and entry.proven_bound and entry.worst):
        return False
    beyond = entry.worst.value - entry.proven_bound.value
    sign = 1.0 if entry.searched.get("sense") in ("<", SIGNS["<="]) else -1.0
    other = entry.searched.get("which_run") != entry.proof.get("found_by")
    return bool(other and sign * beyond > 0.0)


@dataclass(frozen=True, kw_only=True)
class Matrix:
    """All requirements."""

    entries: Sequence[Entry] = field(default_factory=tuple)

    def __bool__(self) -> bool:
        """Return whether there are any."""
        return bool(self.entries)

    def any(self, name: str) -> bool:
        """Return whether an entry has something under a name."""
        return any(bool(getattr(entry, name)) for entry in self.entries)

    def any_asked(self, name: str) -> bool:
        """Return whether a requirement says something in a column of its table."""
        return any(bool(entry.asked[name]) for entry in self.entries)

    def with_verdict(self, *words: str) -> list[Entry]:
        """Return the entries with some verdicts."""
        return [entry for entry in self.entries if entry.verdict.value in words]

    @property
    def verdict(self) -> str:
        """On all requirements together."""
        told = {str(entry.verdict.value) for entry in self.entries}
        return worst_verdict(told) if told else NO_VERDICT


def worst_verdict(words: Iterable[str]) -> str:
    """Return what several verdicts say together; met only if all are."""
    told = set(words)
    for word in (NOT_MET, NO_VERDICT, NOT_SHOWN, NOT_LOOKED_AT):
        if word in told:
            return word
    return MET if told == {MET} else NO_VERDICT


def matrix_of(studies: Studies) -> Matrix:
    """Return the compliance matrix of some studies."""
    tables = {
        "searched": _keyed(studies.rows("requirements.csv")),
        "drawn": _keyed(studies.rows("campaign.csv")),
        "flown": _keyed(studies.rows("requirements_of_run.csv")),
        "beside": _keyed(studies.rows("answers.csv")),
        "proof": _keyed(
            row for row in studies.rows("proofs.csv") if row.get("requirement")
        ),
    }
    status = {
        row.get("label"): str(row.get("status", ""))
        for row in studies.rows("worst_cases.csv")
    }
    evidence = {
        label_of(Worst(str(row.get("objective")))): row
        for row in studies.rows("evidence.csv")
    }
    telling = [rows for name, rows in tables.items() if name != "beside"]
    keys = dict.fromkeys(key for rows in telling for key in rows)
    entries = []
    for key in keys:
        found = {name: rows.get(key) for name, rows in tables.items()}
        searched = found["searched"]
        ended = status.get(searched.get("which_run")) if searched else None
        failed = ended if ended and ended.startswith("failed") else ""
        found["evidence"] = (
            evidence.get(searched.get("which_run")) if searched else None
        )
        entries.append(Entry(**found, unconfirmed=failed))
    return Matrix(entries=entries)


def _keyed(rows: Iterable[Row]) -> Mapping[_Key, Row]:
    """Return rows by what they require, and of several alike by their order."""
    names = ("requirement", "axis", "pair", "sense", "limit", "unit", "id")
    seen: Counter[_Key] = Counter()
    keyed: dict[_Key, Row] = {}
    for row in rows:
        key = tuple(row.get(name, "") for name in names)
        seen[key] += 1
        keyed[*key, seen[key]] = row
    return keyed
