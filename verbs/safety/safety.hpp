// The verbs of `biss safety`, a file each: see verbs/common/verb.hpp.
#pragma once

#include <cstdint>

#include "verbs/common/verb.hpp"

namespace biss::verbs {

Run add_safety_analyse(Verb verb);
Run add_safety_campaign(Verb verb);
Run add_safety_sequences(Verb verb);
Run add_safety_line(Verb verb);
Run add_safety_evidence(Verb verb);

/// The most cycles that `line` takes for a kind of fault.
inline constexpr std::uint64_t most_line_cycles = std::uint64_t{1} << 32U;

}  // namespace biss::verbs
