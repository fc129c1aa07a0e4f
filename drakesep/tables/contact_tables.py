"""Tables of contacts after separation."""

import numpy as np
import pandas as pd

from drakesep.systems.model.parameter_table import XYZ
from drakesep.systems.model.run import Run
from drakesep.tables.columns import in_units
from drakesep.units import with_unit


_CONTACT = ("contact_time", "contact_end", "force_max", "impulse")


def contacts_table(run: Run) -> pd.DataFrame:
    """Return a row for each contact of parts that push each other, in its order."""
    rows = []
    for contact in run.contacts:
        force = np.linalg.norm(contact.force, axis=1)
        ends = np.flatnonzero(force == 0.0)
        for part in np.split(np.arange(len(force)), ends):
            mine = part[force[part] > 0.0]
            if not len(mine):
                continue
            whole = np.arange(max(mine[0] - 1, 0), min(mine[-1] + 2, len(force)))
            impulse = np.trapezoid(contact.force[whole], contact.time[whole], axis=0)
            rows.append(
                {
                    "first": contact.first,
                    "second": contact.second,
                    **in_units(
                        {
                            "contact_time": contact.time[mine[0]],
                            "contact_end": contact.time[whole[-1]],
                            "force_max": float(force[mine].max()),
                            "impulse": float(np.linalg.norm(impulse)),
                        }
                    ),
                }
            )
    columns = ["first", "second", *map(with_unit, _CONTACT)]
    frame = pd.DataFrame(rows, columns=columns)
    return frame.sort_values(columns[2], ignore_index=True)


def contact_forces_table(run: Run) -> pd.DataFrame:
    """Return the forces between parts that touch again: a row for each step."""
    frames = [
        pd.DataFrame(
            {
                with_unit("time"): contact.time,
                "first": contact.first,
                "second": contact.second,
                with_unit("force"): np.linalg.norm(contact.force, axis=1),
                **{
                    with_unit(f"force_{axis}"): contact.force[:, i]
                    for i, axis in enumerate(XYZ)
                },
            }
        )
        for contact in run.contacts
    ]
    if not frames:
        forces = ("force", *(f"force_{axis}" for axis in XYZ))
        names = [with_unit("time"), "first", "second", *map(with_unit, forces)]
        return pd.DataFrame(columns=names)
    return pd.concat(frames, ignore_index=True)
