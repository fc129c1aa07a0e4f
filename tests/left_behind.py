"""What a study leaves in its results folder."""

import json


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
