// Shared by the tests of this room: readers over text, and their edges in one list.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"
#include "capture/event_csv.hpp"
#include "capture/test_pairs.hpp"
#include "capture/vcd.hpp"

namespace biss::wire {

inline void PrintTo(const Edge& edge, std::ostream* out) {
  *out << edge.time.count << " ps: line " << edge.line << " = "
       << "01x"[static_cast<std::size_t>(edge.level)];
}

}  // namespace biss::wire

namespace biss::capture {

inline constexpr std::size_t one_block = std::numeric_limits<std::size_t>::max();

inline void PrintTo(CaptureCause cause, std::ostream* out) {
  *out << "CaptureCause " << static_cast<int>(cause);
}

/// A capture read to its end.
struct Read {
  std::vector<std::string> lines;
  std::vector<wire::Edge> edges;
  Picoseconds end_time;
  std::optional<CaptureError> error;

  std::optional<CaptureCause> cause() const {
    return error ? std::optional(error->cause) : std::nullopt;
  }
};

inline Read read_all(Opened opened) {
  Read read;
  if (!opened) {
    read.error = opened.error();
    return read;
  }
  read.lines = (*opened)->lines();
  for (;;) {
    const auto block = (*opened)->next_block();
    if (!block.ok()) {
      read.error = block.error();
      break;
    }
    if (block->empty()) break;
    read.edges.insert(read.edges.end(), block->begin(), block->end());
  }
  read.end_time = (*opened)->end_time();
  return read;
}

using OpenText = Opened (*)(std::unique_ptr<ByteSource>, std::size_t);

/// Fails the test if pairs() does not give the same changes as next_block().
inline void check_pairs(const Read& read, const Opened& opened, const PairWay& way) {
  if (read.lines.size() <= std::max(way.ma, way.slo)) return;
  const PairRead pairs = read_pairs(opened, way);
  if (!pairs.by_pieces) return;
  const std::string found = difference(pairs_of_edges(read, way), pairs);
  if (!found.empty()) throw std::logic_error("pairs() differs from next_block(): " + found);
}

/// Reads the text, and checks that pieces of it give the same.
inline Read read_text(OpenText open, std::string_view text, std::size_t block) {
  Read read = read_all(open(memory_bytes(text, block), default_piece_bytes));
  check_pairs(read, open(memory_bytes(text, block), default_piece_bytes), {});
  check_pairs(read, open(memory_bytes(text), 64), {.ma = 1, .slo = 0, .blocks = 1});
  return read;
}

inline Read read_vcd(std::string_view text, std::size_t block = one_block) {
  return read_text(open_vcd, text, block);
}

inline Opened open_csv(std::unique_ptr<ByteSource> bytes, std::size_t piece_limit) {
  return open_event_csv(std::move(bytes), piece_limit);
}

inline Read read_csv(std::string_view text, std::size_t block = one_block) {
  return read_text(open_csv, text, block);
}

inline wire::Edge edge(std::int64_t ps, wire::LineIndex line, char level) {
  const auto value = level == '0'   ? wire::Level::low
                     : level == '1' ? wire::Level::high
                                    : wire::Level::unknown;
  return {Picoseconds{ps}, line, value};
}

/// Declarations of MA as `!` and SLO as `"`.
inline std::string vcd_of_ma_and_slo(std::string_view body, std::string_view timescale = "1ps") {
  return "$timescale " + std::string(timescale) +
         " $end\n$scope module cap $end\n$var wire 1 ! MA $end\n$var wire 1 \" SLO $end\n"
         "$upscope $end\n$enddefinitions $end\n" +
         std::string(body);
}

/// Fails in one of its functions.
class FailingSink final : public ByteSink {
 public:
  explicit FailingSink(bool writes) : writes_(writes) {}
  bool write(std::string_view /*bytes*/) override { return writes_; }
  bool flush() override { return !writes_; }

 private:
  bool writes_;
};

}  // namespace biss::capture
