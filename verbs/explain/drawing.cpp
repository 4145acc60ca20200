#include "verbs/explain/drawing.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "device/quantity.hpp"

namespace biss::verbs {

namespace {

using report::Cell;
using report::Kind;

// The level of MA as a number.
std::optional<unsigned> ma_at(const draw::CycleDrawing& drawing, Picoseconds time) {
  wire::Level level = drawing.ma_before;
  for (const decode::LevelChange& change : drawing.ma) {
    if (change.time > time) break;
    level = change.level;
  }
  if (level == wire::Level::unknown) return std::nullopt;
  return level == wire::Level::high ? 1U : 0U;
}

bool mends_alone(const draw::CycleDrawing& drawing, std::size_t payload_bit) {
  return std::any_of(drawing.checks.begin(), drawing.checks.end(), [&](const auto& check) {
    return std::any_of(check.singles.begin(), check.singles.end(),
                       [&](const draw::Flips& flips) { return flips.front() == payload_bit; });
  });
}

}  // namespace

std::vector<report::Column> drawing_columns() {
  return {{.name = "cycle", .kind = Kind::unsigned_integer},
          {.name = "bit", .kind = Kind::unsigned_integer},
          {.name = "time_ns", .kind = Kind::nanoseconds},
          {.name = "ma", .kind = Kind::unsigned_integer},
          {.name = "slo", .kind = Kind::unsigned_integer},
          {.name = "sample", .kind = Kind::nanoseconds},
          {.name = "field", .kind = Kind::text},
          {.name = "clock", .kind = Kind::unsigned_integer},
          {.name = "expected", .kind = Kind::unsigned_integer},
          {.name = "mends", .kind = Kind::flag},
          {.name = "status", .kind = Kind::text}};
}

bool write_drawing(const draw::CycleDrawing& drawing, report::TableWriter& writer) {
  for (const draw::DrawnBit& bit : drawing.bits) {
    const auto number = [](std::optional<bool> level) {
      return level ? Cell(*level ? 1U : 0U) : Cell();
    };
    const Cell cells[] = {drawing.number,
                          bit.payload_bit,
                          bit.time,
                          bit.sampled_at ? ma_at(drawing, *bit.sampled_at) : std::nullopt,
                          number(bit.level),
                          bit.sampled_at,
                          bit.name.empty() ? Cell() : bit.name,
                          bit.clock,
                          number(bit.expected),
                          bit.payload_bit ? mends_alone(drawing, *bit.payload_bit) : Cell(),
                          name_of(drawing.cycle.status)};
    if (!writer.row(cells)) return false;
  }
  return true;
}

std::string drawing_title(const draw::CycleDrawing& drawing) {
  const decode::Cycle& cycle = drawing.cycle;
  std::string text =
      fmt::format("cycle {} at {}: {}", drawing.number, text_of(cycle.time), name_of(cycle.status));
  if (cycle.period) text += fmt::format(", MA {}", text_of(rate_of(*cycle.period), 3));
  if (cycle.line_delay) text += fmt::format(", line delay {}", text_of(*cycle.line_delay, 3));
  if (cycle.early) text += fmt::format(", SLO {} early", text_of(*cycle.early, 3));
  if (cycle.ack) text += fmt::format(", ACK {}", text_of(*cycle.ack, 3));
  return text + "\n";
}

}  // namespace biss::verbs
