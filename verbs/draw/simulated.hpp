// `biss draw` without a capture: cycles of a simulated line.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "draw/cycle_drawing.hpp"
#include "verbs/common/host.hpp"
#include "verbs/simulate/setup.hpp"

namespace biss::verbs {

/// A cycle, and the faults that were injected into it.
struct SimulatedDrawing {
  draw::CycleDrawing drawing;
  std::string faults;
};

struct SimulatedCycles {
  std::optional<FrameFormat> format;
  std::vector<SimulatedDrawing> cycles;
};

/// More than enough for every fault; a longer line is drawn from a capture.
inline constexpr std::uint64_t simulated_cycles_max = 10'000;

/// Draws `count` cycles from cycle `first` on.
/// \param first empty: the first cycle that a fault is injected into by its number, else 0
/// \param ack_clocks the length of ACK; empty: by `line.processing`
tl::expected<SimulatedCycles, VerbError> draw_simulated(LineOptions line,
                                                        std::optional<std::uint64_t> ack_clocks,
                                                        std::optional<std::uint64_t> first,
                                                        std::uint64_t count);

}  // namespace biss::verbs
