// A capture through the flow of pieces and edge by edge: the same cycles, whatever the container, the
// borders of the pieces, the order in which they are expanded, the threads and the SIMD level.
#include <fmt/format.h>
#include <hwy/targets.h>

#include <bit>
#include <deque>
#include <memory>

#include "capture/bytes.hpp"
#include "capture/dsl.hpp"
#include "capture/edge_pairs.hpp"
#include "capture/event_csv.hpp"
#include "capture/open.hpp"
#include "capture/samples.hpp"
#include "capture/sr.hpp"
#include "capture/vcd.hpp"
#include "decode/decoder.hpp"
#include "decode/run_join.hpp"
#include "decode/test_cycle_text.hpp"
#include "flow/cycle_flow.hpp"
#include "flow/piece.hpp"
#include "fuzz/request_lines.hpp"
#include "fuzz/target.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;

constexpr wire::LineIndex other_line = 2;

const std::vector<std::string>& line_names(std::size_t count) {
  static const std::vector<std::string> two{"MA", "SLO"};
  static const std::vector<std::string> three{"MA", "SLO", "other"};
  return count == 2 ? two : three;
}

// The lines as a capture file, and how it is opened.
struct Capture {
  std::string_view name;
  std::string bytes;
  capture::OpenOptions options;
  std::size_t block_bytes = 0;

  capture::Opened open() const {
    return capture::open_capture(capture::memory_bytes(bytes, block_bytes), name, options);
  }
};

// Some changes of another line among these edges.
std::vector<wire::Edge> edges_of(const RequestLines& lines, std::size_t names, ByteSource& bytes) {
  std::vector<wire::Edge> edges = lines.edges();
  if (names == 2) return edges;
  std::vector<wire::Edge> all;
  all.reserve(2 * edges.size());
  const std::size_t every = 1 + bytes.next();
  bool high = false;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    all.push_back(edges[i]);
    if (i % every != 0) continue;
    high = !high;
    all.push_back({edges[i].time, other_line, high ? wire::Level::high : wire::Level::low});
  }
  return all;
}

void make_unknown(std::vector<wire::Edge>& edges, ByteSource& bytes) {
  for (int i = bytes.next() % 3; i > 0; --i) {
    edges[bytes.next_16() % edges.size()].level = wire::Level::unknown;
  }
}

template <class Writer, class... Arguments>
void write(Capture& capture, std::span<const wire::Edge> edges, Picoseconds end,
           const Arguments&... arguments) {
  capture::StringSink sink(capture.bytes);
  Writer writer(arguments..., sink);
  require(writer.write(edges).ok() && writer.finish(end).ok() && sink.flush());
}

// Mostly some samples a period, and never too many for a short execution.
Hertz sample_rate(const RequestLines& lines, Picoseconds end, ByteSource& bytes) {
  constexpr std::int64_t most_samples = 16'384;
  const Picoseconds sample =
      std::max(lines.period / (3 + bytes.next() % 30), end / most_samples + picoseconds(250));
  const std::int64_t rate = 1'000'000'000'000 / sample.count;
  if (bytes.next() % 2 == 0) return Hertz{static_cast<std::uint32_t>(rate)};
  // A period of whole picoseconds.
  constexpr std::array<std::uint32_t, 12> whole{1'000, 500, 250, 200, 125, 100,
                                                50,    25,  10,  5,   2,   1};
  for (const std::uint32_t megahertz_count : whole) {
    if (megahertz_count * std::int64_t{1'000'000} <= rate) return megahertz(megahertz_count);
  }
  return megahertz(1);
}

capture::RawLayout layout_of(std::size_t names, Hertz rate, ByteSource& bytes) {
  if (bytes.next() % 2 == 0) return capture::packed_layout(line_names(names), rate);
  capture::RawLayout layout{.rate = rate, .unit_bytes = 1U + bytes.next() % 8U, .lines = {}};
  const std::size_t bits = 8 * layout.unit_bytes;
  const std::size_t first = bytes.next() % bits;
  const std::size_t step = 1 + bytes.next() % (bits / 3);
  for (std::size_t i = 0; i < names; ++i) {
    layout.lines.push_back(
        {line_names(names)[i], static_cast<unsigned>((first + i * step) % bits)});
  }
  return layout;
}

void write_samples(Capture& capture, const RequestLines& lines, std::size_t names, unsigned kind,
                   ByteSource& bytes) {
  const Picoseconds end = lines.end + nanoseconds(std::int64_t{bytes.next()} * 20);
  const Hertz rate = sample_rate(lines, end, bytes);
  const std::vector<wire::Edge> edges = edges_of(lines, names, bytes);
  if (kind == 0) {
    capture.name = "x.sr";
    write<capture::SrWriter>(capture, edges, end, line_names(names), rate);
  } else if (kind == 1) {
    capture.name = "x.dsl";
    write<capture::DslWriter>(capture, edges, end, line_names(names), rate);
  } else {
    capture.name = "x.raw";
    capture.options.raw = layout_of(names, rate, bytes);
    write<capture::RawWriter>(capture, edges, end, *capture.options.raw);
  }
}

void write_changes(Capture& capture, const RequestLines& lines, std::size_t names, unsigned kind,
                   ByteSource& bytes) {
  const Picoseconds end = lines.end + microseconds(bytes.next_16());
  std::vector<wire::Edge> edges = edges_of(lines, names, bytes);
  if (bytes.next() % 4 == 0) make_unknown(edges, bytes);
  if (kind % 2 == 0) {
    capture.name = "x.vcd";
    write<capture::VcdWriter>(capture, edges, end, line_names(names));
  } else {
    capture.name = "x.csv";
    capture::StringSink sink(capture.bytes);
    capture::EventCsvWriter writer(
        line_names(names), sink,
        kind % 4 == 1 ? capture::CsvDialect::nanoseconds : capture::CsvDialect::saleae);
    require(writer.write(edges).ok() && writer.finish(end).ok() && sink.flush());
  }
}

std::size_t any_size(ByteSource& bytes) {
  const unsigned bits = bytes.next() % 17;
  return 1 + (bytes.next_16() & ((std::size_t{1} << bits) - 1));
}

Capture capture_of(const RequestLines& lines, ByteSource& bytes) {
  Capture capture;
  capture.options.piece_bytes = any_size(bytes);
  capture.options.no_verify = bytes.next() % 4 == 0;
  capture.block_bytes = any_size(bytes);
  const unsigned kind = bytes.next() % 16;
  const std::size_t names = bytes.next() % 4 == 0 ? 3 : 2;
  if (kind < 8) {
    write_samples(capture, lines, names, kind, bytes);
  } else {
    write_changes(capture, lines, names, kind, bytes);
  }
  // A cut capture ends reading with an error, after the same cycles.
  if (bytes.next() % 16 == 0)
    capture.bytes.resize(capture.bytes.size() - capture.bytes.size() * bytes.next() / 512);
  return capture;
}

// How the capture is read by pieces.
struct Way {
  decode::Lines lines;
  unsigned threads = 0;  ///< 0: in this thread, in an order that follows from the input
  std::size_t ahead = 1;
  std::uint64_t order = 0;
  unsigned blocks = 0;  ///< of edges, before the pieces
};

Way way_of(ByteSource& bytes) {
  Way way;
  const unsigned lines = bytes.next();
  way.lines = {.ma = 0, .slo = 1, .ma_inverted = lines % 16 == 1, .slo_inverted = lines % 16 == 2};
  constexpr std::array<unsigned, 3> threads{2, 3, 7};
  const unsigned choice = bytes.next();
  if (choice < threads.size()) way.threads = threads[choice];
  way.ahead = 1 + bytes.next() % 5;
  way.order = bytes.next_16();
  way.blocks = bytes.next() % 4;
  return way;
}

// Pieces that are fetched ahead are expanded in any order.
void decode_here(capture::PairSource& source, const decode::CleanCycleFinder& finder, Way way,
                 decode::Decoder& decoder) {
  struct Waiting {
    std::unique_ptr<flow::Piece> piece;
    bool expanded = false;
  };
  decode::RunJoin join(finder, decoder);
  std::deque<Waiting> pieces;
  std::vector<std::unique_ptr<flow::Piece>> free;
  bool ended = false;
  while (!source.error()) {
    while (!ended && pieces.size() < way.ahead) {
      if (free.empty()) free.push_back(std::make_unique<flow::Piece>(finder));
      ended = !free.back()->fetch(source);
      if (ended) break;
      pieces.push_back({std::move(free.back())});
      free.pop_back();
    }
    if (pieces.empty()) break;
    while (!pieces.front().expanded) {
      way.order = way.order * 25'173 + 13'849;
      Waiting& any = pieces[way.order / 256 % pieces.size()];
      if (!any.expanded) any.piece->expand(way.lines);
      any.expanded = true;
    }
    pieces.front().piece->settle(source, way.lines, join);
    free.push_back(std::move(pieces.front().piece));
    pieces.pop_front();
  }
  join.flush();
}

using Rows = std::vector<std::string>;

// The rows of what `read` pushes, and the error that ends the reading.
template <class Read>
Rows rows(const RequestLines& lines, const capture::Opened& opened, Read read) {
  Rows texts;
  if (!opened) return {capture::capture_error_text(opened.error(), "x")};
  const decode::MarginSetup margin{.resolution = (*opened)->sample_period(),
                                   .signal = lines.period.count % 2 == 0};
  decode::Decoder decoder(
      decode::CycleReader(lines.format, lines.timing, margin),
      [&](const decode::Cycle& cycle) { texts.push_back(decode::test::text_of(cycle)); });
  const std::optional<capture::CaptureError> error = read(**opened, margin, decoder);
  if (error) texts.push_back(capture::capture_error_text(*error, "x"));
  return texts;
}

Rows by_edges(const RequestLines& lines, const Capture& capture, const Way& way) {
  return rows(lines, capture.open(),
              [&](capture::EdgeSource& source, const decode::MarginSetup&,
                  decode::Decoder& decoder) -> std::optional<capture::CaptureError> {
                for (;;) {
                  const auto block = source.next_block();
                  if (block.ok() && !block->empty()) {
                    decoder.push(*block, way.lines);
                    continue;
                  }
                  decoder.finish(source.end_time());
                  if (block.ok()) return std::nullopt;
                  return block.error();
                }
              });
}

Rows by_flow(const RequestLines& lines, const Capture& capture, const Way& way) {
  return rows(lines, capture.open(),
              [&](capture::EdgeSource& source, const decode::MarginSetup& margin,
                  decode::Decoder& decoder) -> std::optional<capture::CaptureError> {
                std::vector<wire::Edge> beginning;
                for (unsigned i = 0; i < way.blocks; ++i) {
                  const auto block = source.next_block();
                  if (!block.ok() || block->empty()) break;
                  beginning.insert(beginning.end(), block->begin(), block->end());
                }
                const auto pairs = capture::pairs_of(std::move(beginning), source, 0, 1);
                const decode::CleanCycleFinder finder(lines.format, lines.timing, margin);
                if (way.threads != 0) {
                  flow::CycleFlow flow(*pairs, finder, way.lines, decoder);
                  flow.run(way.threads, {});
                  flow.flush();
                } else {
                  decode_here(*pairs, finder, way, decoder);
                }
                decoder.finish(pairs->end_time());
                return pairs->error();
              });
}

// One of the SIMD levels of this processor.
void choose_simd(unsigned choice) {
  static const std::int64_t detected = hwy::SupportedTargets();
  std::int64_t levels = detected;
  for (unsigned i =
           choice % static_cast<unsigned>(std::popcount(static_cast<std::uint64_t>(detected)));
       i > 0; --i) {
    levels &= levels - 1;
  }
  hwy::SetSupportedTargetsForTest((levels & -levels) | HWY_STATIC_TARGET);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ByteSource bytes(data, size);
  choose_simd(bytes.next());
  const Way way = way_of(bytes);
  const RequestLines lines = request_lines(bytes);
  const Capture capture = capture_of(lines, bytes);
  const Rows found = by_flow(lines, capture, way);
  const Rows expected = by_edges(lines, capture, way);
  require_same_rows(
      fmt::format("{}, pieces of {} bytes, blocks of {}, {} threads, {} ahead", capture.name,
                  capture.options.piece_bytes, capture.block_bytes, way.threads, way.ahead),
      found, expected);
  return 0;
}
