"""The code of the guide runs as it stands."""

import re
from pathlib import Path

import pytest


GUIDE = Path(__file__).parent.parent / "docs" / "guide.md"
BLOCKS = re.findall(
    r"^```python\n(.*?)^```", GUIDE.read_text(encoding="utf-8"), re.M | re.S
)


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.splitlines()[-1])
def test_code_of_the_guide(block, capsys):
    exec(compile(block, str(GUIDE), "exec"), {"__name__": "__main__"})
    printed = capsys.readouterr().out
    assert ("print" in block) == bool(printed)
    assert "nan" not in printed


def test_there_is_code():
    assert len(BLOCKS) >= 4
