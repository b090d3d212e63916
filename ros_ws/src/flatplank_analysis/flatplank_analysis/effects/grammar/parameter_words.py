# SPDX-License-Identifier: Apache-2.0
"""Words of the parameters that the shapes of a proposed effect have, by name; their units are
those of the site."""

from __future__ import annotations

from flatplank_analysis.word import Word

WAVE = "Of a wave that begins with {} at zero; the size is the root of the sum of both squares."
WORDS = {
    "amount": Word("size", "How large the change is, as its form says.", symbol="a"),
    "cos": Word("cosine part", WAVE.format("its crest"), symbol="a_c"),
    "sin": Word("sine part", WAVE.format("its rise"), symbol="a_s"),
    "second_cos": Word("cosine part of the second wave", "As `cos`, in a beat.", symbol="b_c"),
    "second_sin": Word("sine part of the second wave", "As `sin`, in a beat.", symbol="b_s"),
    "at": Word("beginning", "Value from which on the change is there.", symbol="u_0"),
    "start": Word("beginning of the bump", "Value at which the bump rises.", symbol="u_1"),
    "length": Word(
        "length of the change",
        "Whole length of a bump; of a relaxation that over which two thirds of it are done.",
        symbol="l",
    ),
    "power": Word("power", "Exponent of the distance from the lower end.", symbol="n"),
    "band": Word("half width of the dead band", "Nothing changes up to it.", symbol="u_d"),
    "scale": Word("width of the rise", "At this value three quarters are reached.", symbol="u_r"),
    "lag": Word("time of the lag", "Time constant with which the change follows.", symbol="τ"),
    "gap": Word("play", "Way between moving forward and moving back.", symbol="g"),
    "period": Word("period", "Distance after which the wave comes again.", symbol="λ"),
    "second": Word("period of the second wave", "The other period of a beat.", symbol="λ_2"),
    "fade": Word("decay length", "Length over which the wave falls to a third.", symbol="l_f"),
}
