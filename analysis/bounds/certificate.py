"""Certificates: what was proven, and how, for a second program to check.

The format is that of docs/proof.md, section 8: JSON, every real number as a hexadecimal
float.
"""

import dataclasses
import json
import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from drakesep.analysis.bounds.branch_and_bound import Node, Proof
from drakesep.analysis.bounds.grid import Grid
from drakesep.analysis.bounds.motion import SWEEPS, TRIES
from drakesep.analysis.bounds.problem import BoundProblem, Number
from drakesep.analysis.bounds.quantities import Quantity


FORMAT = "drakesep proof 2"
MOST = 50_000_000
"""Bytes of a certificate: what reads and checks it holds all of it."""


def certificate(
    problem: BoundProblem, grid: Grid, proofs: Mapping[str, Proof]
) -> dict[str, Any]:
    """Return what a certificate holds.

    Args:
        problem: of which bounds are proven.
        grid: of time.
        proofs: by the names of their claims.
    """
    return {
        "format": FORMAT,
        "made_by": {
            "drakesep": version("drakesep"),
            "numpy": version("numpy"),
            "python": platform.python_version(),
        },
        "problem": _plain(problem),
        "grid": {"times": _plain(grid.times.tolist()), "push": grid.push},
        "method": {"sweeps": SWEEPS, "tries": TRIES},
        "claims": [_claim(name, proof) for name, proof in proofs.items()],
    }


def write_certificate(
    path: Path, problem: BoundProblem, grid: Grid, proofs: Mapping[str, Proof]
) -> tuple[str, ...]:
    """Write a certificate of the claims that fit into it; see `certificate`.

    It is at most `MOST` long. The shortest proofs go first, so that one of many boxes
    takes no other along; if not even one fits, nothing is written.

    Args:
        path: of the file.
        problem: of which bounds are proven.
        grid: of time.
        proofs: by the names of their claims.

    Returns:
        Names of the claims that do not fit.
    """
    record = certificate(problem, grid, proofs)
    texts = {claim["name"]: _text(claim) for claim in record["claims"]}
    length = len(_text({**record, "claims": []})) + 1
    fitting = set()
    for name in sorted(texts, key=lambda name: len(texts[name])):
        length += len(texts[name]) + 1
        if length <= MOST:
            fitting.add(name)
    record["claims"] = [c for c in record["claims"] if c["name"] in fitting]
    if fitting:
        path.write_text(_text(record) + "\n", encoding="utf-8")
    return tuple(name for name in texts if name not in fitting)


def _text(record: Any) -> str:
    return json.dumps(record, separators=(",", ":"))


def _claim(name: str, proof: Proof) -> dict[str, Any]:
    return {
        "name": name,
        "quantity": _quantity(proof.quantity),
        "bound": proof.bound.hex(),
        "found": proof.found.hex(),
        "at": _plain(proof.at),
        "tree": nodes_of(proof.tree),
    }


def _quantity(quantity: Quantity) -> dict[str, Any]:
    return {
        "kind": quantity.kind,
        "terms": [
            {
                "field": term.signal.field,
                "pair": term.signal.pair,
                "law": term.signal.law,
                "component": term.signal.component,
                "vector": _plain(term.signal.vector),
                "signs": list(term.signs),
                "pieces": [term.first, term.last],
                "blocks": list(term.blocks),
                "coast": term.coast,
                "levels": _plain(term.levels),
            }
            for term in quantity.terms
        ],
    }


def nodes_of(tree: Node | Sequence[Any]) -> list[Any]:
    """Return the nodes of a tree, each before its children, the lower one first.

    Args:
        tree: its root; or its nodes, as this has returned them.
    """
    if not isinstance(tree, Node):
        return list(tree)
    nodes: list[Any] = []
    pending = [tree]
    while pending:
        node = pending.pop()
        pending.extend(reversed(node.children))
        centre = None if node.centre is None else _plain(node.centre.tolist())
        if node.split:
            nodes.append(["split", [_chosen(child) for child in node.children], centre])
        elif node.cut is not None:
            nodes.append(["cut", node.cut[0], node.cut[1].hex()])
        elif node.faces:
            sides = {str(i): "upper" if up else "lower" for i, up in node.faces.items()}
            nodes.append(["collapse", sides])
        else:
            nodes.append(["leaf", centre])
    return nodes


def _chosen(node: Node) -> list[int]:
    """Return the choices that a node looks at."""
    assert node.chosen is not None
    return [int(c) for c in np.flatnonzero(node.chosen)]


def _plain(value: Any) -> Any:
    """Return a record as lists, mappings and texts, its floats in hexadecimal."""
    if isinstance(value, Number):
        number: dict[str, Any] = {"value": value.value.hex()}
        if value.parameter is not None:
            number["parameter"] = value.parameter
        return number
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {
            field.name: _plain(getattr(value, field.name))
            for field in dataclasses.fields(value)
        }
    if isinstance(value, (float, np.floating)):
        return float(value).hex()
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(x) for x in value]
    return value
