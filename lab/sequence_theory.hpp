// The share of injected faults that must be accepted, by exact calculation;
// docs/safety-experiments.md derives it.
#pragma once

#include "lab/sequence_frame.hpp"

namespace biss::lab {

/// Flips or a burst. Not known if campaign_theory() returns nothing.
SequenceTheory corruption_theory;
/// A frame of another source: its counter is the expected one by chance.
SequenceTheory counter_theory;
/// The same for a frame between two requests. It can come too early.
SequenceTheory insertion_theory;
/// Random bits instead of both words, or instead of the safety word.
SequenceTheory noise_theory;
SequenceTheory noise_word_theory;
/// The right words with another polynomial of the safety word's CRC.
SequenceTheory polynomial_theory;
/// Zeros instead of the safety word. Not known if that is a good word.
SequenceTheory standard_theory;

/// 0 for rows without an injected fault, else the value for the variant.
SequenceTheory sequence_theory;

}  // namespace biss::lab
