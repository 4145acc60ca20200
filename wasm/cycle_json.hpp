// A cycle as the page gets it.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "biss/frame/format.hpp"
#include "decode/cycle_edges.hpp"

namespace biss::wasm {

/// Picoseconds have more digits than a number of the page.
inline std::string exact(Picoseconds time) { return std::to_string(time.count); }

/// The cycle as one line; bytes that are not UTF-8 are replaced.
inline std::string dumped(const nlohmann::json& value) {
  return value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// A cycle bit by bit, and part by part as `biss draw` lays it out: `Cycle` of biss.d.mts.
/// \param number of the cycle in its capture
nlohmann::json cycle_json(std::uint64_t number, const decode::CycleEdges& edges,
                          const std::optional<FrameFormat>& format, const DeviceTiming& timing,
                          const decode::MarginSetup& margin);

}  // namespace biss::wasm
