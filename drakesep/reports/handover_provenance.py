"""Where files that are handed over come from, and what was said at the export."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from drakesep.files import write_text
from drakesep.results.reading import Results
from drakesep.version import __version__


FORMAT = 1
"""Of the file: another number means other keys."""
_NOTHING: Mapping[str, str] = MappingProxyType({})


def save_provenance(
    results: Results,
    files: Sequence[Path],
    format: str,
    run: str = "",
    given: Mapping[str, str] = _NOTHING,
) -> Path:
    """Write where files come from as ``RUN_FORMAT_provenance.json`` beside them.

    Args:
        results: that they were made of.
        files: one or more, in one folder.
        format: as `export` has it.
        run: label of the run that is handed over; empty: a campaign is.
        given: what was said at the export, since the case does not, by its name.

    Returns:
        The file.
    """
    record = results.record
    data = {
        "format": FORMAT,
        "made_by": f"drakesep {__version__}",
        "case": record.case.get("name"),
        "case_sha256": record.case.get("sha256"),
        "study": record.study,
        "begun": record.begun,
        "versions": dict(record.versions),
        "commit": record.commit,
        "run": run,
        "given": dict(given),
        "files": {
            file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in files
        },
    }
    name = f"{run or record.study}_{format}_provenance.json"
    file = files[0].with_name(name)
    write_text(file, json.dumps(data, indent=1, ensure_ascii=False) + "\n")
    return file
