#include "capture/edge_pairs.hpp"

#include <algorithm>
#include <utility>

namespace biss::capture {

namespace {

// Enough edges to give a thread a piece of its own.
constexpr std::size_t edges_in_piece = 32'768;

class EdgePiece final : public PairPiece {
 public:
  EdgePiece(wire::LineIndex ma_line, wire::LineIndex slo_line)
      : ma_line_(ma_line), slo_line_(slo_line) {}

  void expand() override { regular = take_changes(edges, ma_line_, slo_line_, ma, slo); }

  std::vector<wire::Edge> edges;
  bool regular = false;
  // The error that ended the reading after these edges, and the time that the capture has reached
  // with them.
  std::optional<CaptureError> error;
  Picoseconds end_time;

 private:
  wire::LineIndex ma_line_;
  wire::LineIndex slo_line_;
};

class EdgePairs final : public PairSource {
 public:
  EdgePairs(std::vector<wire::Edge> edges, EdgeSource& source, wire::LineIndex ma,
            wire::LineIndex slo)
      : first_(std::move(edges)),
        first_pieces_((first_.size() + edges_in_piece - 1) / edges_in_piece),
        source_(source),
        own_(source.pairs(ma, slo)),
        ma_(ma),
        slo_(slo) {}

  std::unique_ptr<PairPiece> fetch(std::unique_ptr<PairPiece> used) override {
    const bool is_edges = dynamic_cast<EdgePiece*>(used.get()) != nullptr;
    if (taken_ == first_.size() && own_) return own_->fetch(is_edges ? nullptr : std::move(used));
    if (!is_edges) used = std::make_unique<EdgePiece>(ma_, slo_);
    auto& piece = static_cast<EdgePiece&>(*used);
    piece.edges.clear();
    if (taken_ < first_.size()) {
      fetch_first(piece);
    } else if (!ended_) {
      fetch_edges(piece);
    } else {
      return nullptr;
    }
    return used;
  }

  bool settle(PairPiece& piece, const OnEdges& on_edges) override {
    if (settled_ >= first_pieces_ && own_) return own_->settle(piece, on_edges);
    ++settled_;
    const auto& edges = static_cast<EdgePiece&>(piece);
    error_ = edges.error;
    end_time_ = edges.end_time;
    if (!edges.regular) on_edges(edges.edges);
    return edges.regular;
  }

  Picoseconds end_time() const override {
    return own_ ? std::max(end_time_, own_->end_time()) : end_time_;
  }
  const std::optional<CaptureError>& error() const override {
    // The error of the source may be known before the first edges are settled.
    return own_ && settled_ >= first_pieces_ ? own_->error() : error_;
  }

 private:
  void fetch_first(EdgePiece& piece) {
    const std::size_t count = std::min(first_.size() - taken_, edges_in_piece);
    const auto begin = first_.begin() + static_cast<std::ptrdiff_t>(taken_);
    piece.edges.assign(begin, begin + static_cast<std::ptrdiff_t>(count));
    piece.end_time = piece.edges.back().time;
    taken_ += count;
  }

  // The last piece may have no edges: it only holds the end time of the capture.
  void fetch_edges(EdgePiece& piece) {
    while (!ended_ && piece.edges.size() < edges_in_piece) {
      const auto block = source_.next_block();
      ended_ = !block.ok() || (*block).empty();
      if (!block.ok()) piece.error = block.error();
      if (!ended_) piece.edges.insert(piece.edges.end(), (*block).begin(), (*block).end());
    }
    piece.end_time = source_.end_time();
  }

  std::vector<wire::Edge> first_;
  std::size_t first_pieces_;
  EdgeSource& source_;
  std::unique_ptr<PairSource> own_;
  wire::LineIndex ma_;
  wire::LineIndex slo_;
  // Used by fetch().
  std::size_t taken_ = 0;
  bool ended_ = false;
  // Used by settle().
  std::size_t settled_ = 0;
  Picoseconds end_time_;
  std::optional<CaptureError> error_;
};

}  // namespace

bool take_changes(std::span<const wire::Edge> edges, wire::LineIndex ma, wire::LineIndex slo,
                  LineChanges& ma_changes, LineChanges& slo_changes) {
  ma_changes.clear();
  slo_changes.clear();
  for (const wire::Edge& edge : edges) {
    if (edge.line != ma && edge.line != slo) continue;
    LineChanges& changes = edge.line == ma ? ma_changes : slo_changes;
    if (edge.level == wire::Level::unknown) return false;
    if (changes.times.empty()) changes.first_high = edge.level == wire::Level::high;
    changes.times.push_back(edge.time.count);
  }
  return true;
}

std::unique_ptr<PairSource> pairs_of(std::vector<wire::Edge> edges, EdgeSource& source,
                                     wire::LineIndex ma, wire::LineIndex slo) {
  return std::make_unique<EdgePairs>(std::move(edges), source, ma, slo);
}

}  // namespace biss::capture
