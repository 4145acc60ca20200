// A capture's pieces through all cores: fetched one after the other, expanded and searched for clean
// cycles by any thread, decoded in their order.
#pragma once

#include <functional>

#include "capture/pair_source.hpp"
#include "decode/clean_cycles.hpp"
#include "decode/decoder.hpp"
#include "flow/piece.hpp"

namespace biss::flow {

struct FlowSetup {
  decode::Lines lines;
  /// 1: all in the thread that calls. 0: one for each processor of the machine.
  unsigned threads = 0;
  Watch watch = {};
  /// Called after each piece; false ends the reading.
  std::function<bool()> go_on = nullptr;
};

/// Reads the capture to its end, or to a read error, into the decoder; does not finish the decoder.
/// The cycles are the same for any number of threads. Memory has a few pieces for each thread.
void decode_pieces(capture::PairSource& source, const decode::CleanCycleFinder& finder,
                   const FlowSetup& setup, decode::Decoder& decoder);

}  // namespace biss::flow
