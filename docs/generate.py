"""Writes the tables of the pages that are made of what the code says of itself.

    python docs/generate.py

A page holds them between two comments, which say which table it is; the rest of it is
written by hand. A test holds the pages to it.
"""

import re
from collections.abc import Callable, Mapping
from pathlib import Path

from case_file_keys import keys_of_case_files
from metric_table import table_of_metrics, table_of_quantities
from parameter_table import table_of_magnitudes, table_of_parameters
from port_tables import tables_of_ports
from result_tables import table_of_study, tables_of_results
from summary_tables import tables_of_summaries


DOCS = Path(__file__).parent
TABLES: Mapping[str, Mapping[str, Callable[[], str]]] = {
    "command_line.md": {"summaries": tables_of_summaries},
    "case_file.md": {"keys": keys_of_case_files},
    "metrics.md": {"metrics": table_of_metrics, "quantities": table_of_quantities},
    "parameters.md": {
        "parameters": table_of_parameters,
        "magnitudes": table_of_magnitudes,
    },
    "ports.md": {"ports": tables_of_ports},
    "results.md": {"study": table_of_study, "files": tables_of_results},
}
"""By page and by the name of the table."""


def filled(page: str) -> str:
    """Return the text of a page with its tables as they should be.

    Raises:
        ValueError: the page has no place for one of them.
    """
    text = (DOCS / page).read_text(encoding="utf-8")
    for name, make in TABLES[page].items():
        place = rf"(<!-- generated: {name} -->\n).*?(\n<!-- end -->)"
        table = f"\n{make()}\n"
        text, places = re.subn(
            place,
            lambda found, table=table: found[1] + table + found[2],
            text,
            flags=re.S,
        )
        if places != 1:
            raise ValueError(f"{page}: must have one place for {name}, got {places}")
    return text


def main() -> None:
    """Write all pages."""
    for page in TABLES:
        (DOCS / page).write_text(filled(page), encoding="utf-8")


if __name__ == "__main__":
    main()
