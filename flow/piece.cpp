#include "flow/piece.hpp"

#include <utility>

namespace biss::flow {

bool Piece::fetch(capture::PairSource& source) {
  piece_ = source.fetch(std::move(piece_));
  return piece_ != nullptr;
}

void Piece::expand(const decode::Lines& lines, std::size_t others) {
  piece_->expand();
  finder_.find(run_of(lines), clean_, piece_->ahead(others));
}

void Piece::settle(capture::PairSource& source, const decode::Lines& lines, decode::RunJoin& join,
                   ChangeWatcher* watcher) {
  const bool regular = source.settle(*piece_, [&](std::span<const wire::Edge> edges) {
    if (watcher != nullptr) watcher->take(edges);
    join.push(edges, lines);
  });
  if (!regular) return;
  join.push(run_of(lines), clean_);
  if (watcher != nullptr) watcher->take(*piece_);
}

decode::PairRun Piece::run_of(const decode::Lines& lines) const {
  return {{piece_->ma.times, piece_->ma.first_high != lines.ma_inverted},
          {piece_->slo.times, piece_->slo.first_high != lines.slo_inverted}};
}

}  // namespace biss::flow
