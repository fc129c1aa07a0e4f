"""Results folders: what a study leaves, and how it is read again.

A folder holds one study: its tables and plots, ``study.json`` that says what was asked
and how it ended, the case in SI with its geometry, and the motion of all bodies, joint
loads and spring forces of each run that is shown.
"""
