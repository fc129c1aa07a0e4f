"""Trajectories and attitudes of other programs: CCSDS OEM and AEM, read and written."""
