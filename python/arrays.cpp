#include "python/arrays.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "capture/change_edges.hpp"
#include "capture/edge_pairs.hpp"

namespace biss::python {
namespace {

using capture::CaptureCause;
using capture::CaptureError;
using capture::PairPiece;
using capture::PairSource;
using wire::Level;

// Enough changes to give a thread a piece of its own.
constexpr std::size_t elements_in_piece = 32'768;
// A block of edges.
constexpr std::size_t elements_in_block = 4'096;

const std::vector<std::string>& line_names() {
  static const std::vector<std::string> names{"MA", "SLO"};
  return names;
}

CaptureError backwards_at(std::size_t element) {
  return {.cause = CaptureCause::time_backwards, .part = "element", .part_number = element + 1};
}

class ArrayPiece final : public PairPiece {
 public:
  explicit ArrayPiece(const EdgeArrays& arrays) : arrays_(arrays) {}

  void set(std::size_t from, std::size_t to) {
    from_ = from;
    to_ = to;
  }
  void expand() override {
    ma.times.resize(to_ - from_);
    slo.times.resize(to_ - from_);
    std::int64_t last = from_ == 0 ? arrays_.times[0] : arrays_.times[from_ - 1];
    Changes ma_changes(ma.times.data());
    Changes slo_changes(slo.times.data());
    for (read_ = from_; read_ < to_ && arrays_.times[read_] >= last; ++read_) {
      last = arrays_.times[read_];
      ma_changes.put(last, arrays_.ma[read_] != 0);
      slo_changes.put(last, arrays_.slo[read_] != 0);
    }
    ma_changes.finish(ma);
    slo_changes.finish(slo);
  }

  bool whole() const { return read_ == to_; }
  // The end of the elements whose times do not fall.
  std::size_t read() const { return read_; }

 private:
  // Writes every time and keeps the times of changes, so that no branch depends on the levels.
  class Changes {
   public:
    explicit Changes(std::int64_t* times) : times_(times) {}

    void put(std::int64_t time, bool high) {
      times_[count_] = time;
      count_ += level_ != static_cast<int>(high) ? 1U : 0U;
      level_ = static_cast<int>(high);
    }
    void finish(capture::LineChanges& changes) const {
      changes.times.resize(count_);
      changes.first_high = (level_ == 1) == (count_ % 2 == 1);
    }

   private:
    std::int64_t* times_;
    std::size_t count_ = 0;
    int level_ = -1;
  };

  const EdgeArrays& arrays_;
  std::size_t from_ = 0;
  std::size_t to_ = 0;
  std::size_t read_ = 0;
};

class ArrayPairs final : public PairSource {
 public:
  ArrayPairs(const EdgeArrays& arrays, std::size_t from)
      : arrays_(arrays), fetched_(from), changes_(ma_line, slo_line) {
    if (from == 0) return;
    changes_.set(arrays.ma[from - 1] != 0, arrays.slo[from - 1] != 0);
    end_time_ = Picoseconds{arrays.times[from - 1]};
  }

  std::unique_ptr<PairPiece> fetch(std::unique_ptr<PairPiece> used) override {
    if (fetched_ == arrays_.times.size()) return nullptr;
    if (!used) used = std::make_unique<ArrayPiece>(arrays_);
    const std::size_t end = std::min(arrays_.times.size(), fetched_ + elements_in_piece);
    static_cast<ArrayPiece&>(*used).set(std::exchange(fetched_, end), end);
    return used;
  }

  bool settle(PairPiece& piece, const OnEdges& on_edges) override {
    const auto& element = static_cast<const ArrayPiece&>(piece);
    if (element.read() != 0) end_time_ = Picoseconds{arrays_.times[element.read() - 1]};
    if (element.whole()) {
      changes_.skip(piece.ma, piece.slo);
      return true;
    }
    error_ = backwards_at(element.read());
    changes_.put(piece.ma, piece.slo, on_edges);
    return false;
  }

  Picoseconds end_time() const override { return end_time_; }
  const std::optional<CaptureError>& error() const override { return error_; }

 private:
  const EdgeArrays& arrays_;
  std::size_t fetched_;
  capture::ChangeEdges changes_;
  Picoseconds end_time_;
  std::optional<CaptureError> error_;
};

class ArraySource final : public capture::EdgeSource {
 public:
  explicit ArraySource(const EdgeArrays& arrays) : arrays_(arrays) {}

  const std::vector<std::string>& lines() const override { return line_names(); }
  Result<std::span<const wire::Edge>, CaptureError> next_block() override {
    block_ = {};
    while (block_.empty() && at_ < arrays_.times.size()) {
      piece_.set(at_, std::min(arrays_.times.size(), at_ + elements_in_block));
      piece_.expand();
      if (piece_.read() == at_) return failure(backwards_at(at_));
      at_ = piece_.read();
      changes_.put(piece_.ma, piece_.slo, [this](auto edges) { block_ = edges; });
    }
    return block_;
  }
  Picoseconds end_time() const override {
    return at_ == 0 ? Picoseconds{} : Picoseconds{arrays_.times[at_ - 1]};
  }
  Picoseconds sample_period() const override { return arrays_.sample_period; }
  std::unique_ptr<PairSource> pairs(wire::LineIndex ma, wire::LineIndex slo) override {
    // With the lines exchanged, edges are good enough.
    if (ma != ma_line || slo != slo_line) return nullptr;
    return std::make_unique<ArrayPairs>(arrays_, at_);
  }

 private:
  EdgeArrays arrays_;
  ArrayPiece piece_{arrays_};
  capture::ChangeEdges changes_{ma_line, slo_line};
  std::size_t at_ = 0;
  std::span<const wire::Edge> block_;
};

class PushedPiece final : public PairPiece {
 public:
  PushedPiece(wire::LineIndex ma_index, wire::LineIndex slo_index)
      : ma_index_(ma_index), slo_index_(slo_index) {}
  void expand() override { capture::take_changes(edges, ma_index_, slo_index_, ma, slo); }

  std::vector<wire::Edge> edges;

 private:
  wire::LineIndex ma_index_;
  wire::LineIndex slo_index_;
};

class PushedPairs final : public PairSource {
 public:
  PushedPairs(EdgeQueue& queue, wire::LineIndex ma, wire::LineIndex slo)
      : queue_(queue), ma_(ma), slo_(slo) {}

  std::unique_ptr<PairPiece> fetch(std::unique_ptr<PairPiece> used) override {
    if (queue_.empty()) return nullptr;
    if (!used) used = std::make_unique<PushedPiece>(ma_, slo_);
    static_cast<PushedPiece&>(*used).edges = queue_.take();
    return used;
  }
  // No level is unknown.
  bool settle(PairPiece& /*piece*/, const OnEdges& /*on_edges*/) override { return true; }
  Picoseconds end_time() const override { return queue_.end_time(); }
  const std::optional<CaptureError>& error() const override { return error_; }

 private:
  EdgeQueue& queue_;
  wire::LineIndex ma_;
  wire::LineIndex slo_;
  std::optional<CaptureError> error_;
};

class PushedSource final : public capture::EdgeSource {
 public:
  explicit PushedSource(EdgeQueue& queue) : queue_(queue) {}

  const std::vector<std::string>& lines() const override { return line_names(); }
  Result<std::span<const wire::Edge>, CaptureError> next_block() override {
    delivered_ = queue_.take();
    return std::span<const wire::Edge>(delivered_);
  }
  Picoseconds end_time() const override { return queue_.end_time(); }
  Picoseconds sample_period() const override { return queue_.sample_period(); }
  std::unique_ptr<PairSource> pairs(wire::LineIndex ma, wire::LineIndex slo) override {
    return std::make_unique<PushedPairs>(queue_, ma, slo);
  }

 private:
  EdgeQueue& queue_;
  std::vector<wire::Edge> delivered_;
};

}  // namespace

capture::Opened open_arrays(const EdgeArrays& arrays) {
  if (arrays.times.empty()) return tl::unexpected(CaptureError{.cause = CaptureCause::empty});
  return std::make_unique<ArraySource>(arrays);
}

void EdgeQueue::push(Picoseconds time, bool ma, bool slo) {
  put(time, slo_line, slo, slo_);
  put(time, ma_line, ma, ma_);
  end_ = begun_ ? std::max(end_, time) : time;
  begun_ = true;
}

void EdgeQueue::put(Picoseconds time, wire::LineIndex line, bool high, Level& last) {
  const Level level = high ? Level::high : Level::low;
  if (std::exchange(last, level) != level) edges_.push_back({time, line, level});
}

std::unique_ptr<capture::EdgeSource> EdgeQueue::source() {
  return std::make_unique<PushedSource>(*this);
}

}  // namespace biss::python
