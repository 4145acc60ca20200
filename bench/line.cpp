#include "bench/line.hpp"

#include <string>

#include "biss/frame/format_text.hpp"
#include "capture/bytes.hpp"
#include "capture/event_csv.hpp"
#include "capture/vcd.hpp"
#include "sim/line.hpp"

namespace biss::bench {

namespace {

template <class Writer>
std::string written(const Line& line) {
  std::string text;
  capture::StringSink sink(text);
  Writer writer({"MA", "SLO"}, sink);
  if (!writer.write(line.edges).ok() || !writer.finish(line.end).ok()) return {};
  return text;
}

}  // namespace

Line make_line(std::size_t cycles) {
  static_assert(sim::ma_line == 0 && sim::slo_line == 1);
  Line line{.format = parse_format(line_format_text).value(), .cycles = cycles, .edges = {}};
  sim::LineSetup setup;
  setup.format = line.format;
  setup.clock = megahertz(10);
  setup.ma_delay = setup.slo_delay = nanoseconds(115);
  setup.motion = sim::MotionKind::random;
  sim::Line source(setup);
  // Both lines idle, so that the first cycle is seen from its beginning.
  line.edges = {{Picoseconds{}, sim::ma_line, wire::Level::high},
                {Picoseconds{}, sim::slo_line, wire::Level::high}};
  for (std::size_t i = 0; i < cycles; ++i) {
    const auto& cycle = source.next();
    line.edges.insert(line.edges.end(), cycle.edges.begin(), cycle.edges.end());
  }
  line.end = line.edges.back().time + microseconds(100);
  return line;
}

std::string vcd_text(const Line& line) { return written<capture::VcdWriter>(line); }

std::string csv_text(const Line& line) { return written<capture::EventCsvWriter>(line); }

}  // namespace biss::bench
