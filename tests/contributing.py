"""The examples of CONTRIBUTING.md."""

import re
from pathlib import Path


def example(title: str) -> str:
    """The Python under a title, such as `new command`."""
    text = Path(__file__).parents[1].joinpath("CONTRIBUTING.md").read_text("utf-8")
    blocks = re.findall(r"^```python\n(.*?)^```", text.partition(f"## A {title}\n")[2], re.M | re.DOTALL)
    return str(blocks[0])
