"""Which files a results folder has, and what their columns mean.

Said once: `study.json` and the page ``docs/results.md`` list them from here. A name in
braces stands for many: ``{label}`` for that of a run, ``{metric}`` for each metric,
whose meaning is that of its registry.
"""
