# SPDX-License-Identifier: Apache-2.0
"""Results of a kit belong to code that does the same, however it is explained."""

from __future__ import annotations

import pytest

from flatplank_validation.blind.fingerprint import fingerprint

CODE = '''"""Text."""
SIZE = 0.5
"""share"""


class Law:
    """Of the force."""

    what = "text of an effect"

    def at(self, x: float) -> float:
        """Force."""
        return SIZE * x  # N
'''


@pytest.mark.parametrize(
    ("old", "new", "same"),
    [
        ("Force.", "Force [N].", True),
        ("# N", "# newton", True),
        ('"""share"""', '"""Share."""', True),
        ("SIZE * x", "(SIZE\n                * x)", True),
        ("0.5", "0.6", False),
        ("SIZE * x", "x * SIZE", False),
        ("text of an effect", "another text", False),
    ],
)
def test_only_what_the_code_does_counts(tmp_path, old, new, same):
    one, other = tmp_path / "one.py", tmp_path / "other.py"
    one.write_text(CODE)
    other.write_text(CODE.replace(old, new))
    assert other.read_text() != CODE
    assert (fingerprint([one]) == fingerprint([other])) is same
