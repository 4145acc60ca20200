// For machines without threads: takes the place of cycle_flow.cpp.
#include "flow/cycle_flow.hpp"
#include "flow/piece.hpp"

namespace biss::flow {

void decode_pieces(capture::PairSource& source, const decode::CleanCycleFinder& finder,
                   const FlowSetup& setup, decode::Decoder& decoder) {
  Piece piece(finder);
  decode::RunJoin join(finder, decoder);
  bool wanted = true;
  while (wanted && piece.fetch(source)) {
    piece.expand(setup.lines);
    piece.settle(source, setup.lines, join, setup.watch);
    wanted = !source.error() && (!setup.go_on || setup.go_on());
  }
  join.flush();
}

}  // namespace biss::flow
