"""A checker of proofs, which stands alone: it shares no code with what made them.

    python -m drakesep.check_proof proof.json

reads a certificate of the form of docs/proof.md, encloses the motion anew in Arb on
every box that the certificate says something of, and looks whether what it says is so.
It needs Python and python-flint alone: copied to another machine, the folder runs as
`python -m check_proof proof.json`. Numbers of equations are those of docs/proof.md.
"""
