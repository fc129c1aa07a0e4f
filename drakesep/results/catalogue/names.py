"""Names of the studies that write results folders, and of what stands in those."""

SIMULATE, CLEARANCE = "simulate", "clearance"
WORST_CASE, VERIFY = "worst-case", "verify"
SWEEP, CAMPAIGN = "sweep", "campaign"
SENSITIVITY, RARE_EVENTS = "sensitivity", "rare-events"
PROVE = "prove"
OF_KEPT_RUNS = (SIMULATE, CLEARANCE, WORST_CASE, VERIFY)
SEARCHED = (WORST_CASE, VERIFY)
OF_CAMPAIGN = (CAMPAIGN, VERIFY)
"""In `verify`, if one was flown beside the worst cases."""
PROVEN = (PROVE, VERIFY)
"""In `verify`, if it is asked for."""
STUDIES = (*OF_KEPT_RUNS, SWEEP, CAMPAIGN, SENSITIVITY, RARE_EVENTS, PROVE)
"""Those that write a folder."""
STUDY, CASE = "study.json", "case.json"
RUNS = "runs"
"""Folder of what is kept of each run."""
TABLE = ".csv.gz"
"""Ending of their motion: of many bodies it takes megabytes, a third of them so."""
GEOMETRY = "geometry"
"""Folder of the meshes, as they were when they were measured."""
