#include "verbs/simulate/truth.hpp"

#include <fmt/format.h>

#include "biss/frame/format_text.hpp"
#include "verbs/simulate/fault_option.hpp"

namespace biss::verbs {

using report::Cell;
using report::Kind;

TruthTable::TruthTable(const FrameFormat& format, bool changes) : format_(format) {
  columns_ = {{.name = "cycle", .kind = Kind::unsigned_integer},
              {.name = "time_ns", .kind = Kind::nanoseconds},
              {.name = "position", .kind = Kind::unsigned_integer},
              {.name = "nE", .kind = Kind::flag},
              {.name = "nW", .kind = Kind::flag},
              {.name = "faults", .kind = Kind::text}};
  for (std::size_t k = 1; k < format.channel_count; ++k) {
    columns_.push_back({.name = fmt::format("position{}", k + 1), .kind = Kind::unsigned_integer});
    columns_.push_back({.name = fmt::format("nE{}", k + 1), .kind = Kind::flag});
    columns_.push_back({.name = fmt::format("nW{}", k + 1), .kind = Kind::flag});
  }
  columns_.push_back({.name = "places", .kind = Kind::text});
  columns_.push_back({.name = "marginal", .kind = Kind::flag});
  columns_.push_back({.name = "sampled_ns", .kind = Kind::nanoseconds});
  if (!changes) return;
  columns_.push_back({.name = "format", .kind = Kind::text});
  set_format(format);
}

void TruthTable::set_format(const FrameFormat& format) {
  format_ = format;
  text_ = format_text(format).view();
}

const std::vector<Cell>& TruthTable::cells(std::uint64_t number, const sim::SimulatedCycle& cycle) {
  cells_.clear();
  faults_ = sim::text_of(cycle.faults);
  places_ = text_of(cycle.injected);
  cells_.emplace_back(number);
  cells_.emplace_back(cycle.time);
  for (std::size_t k = 0; k < format_.channel_count; ++k) {
    // Values that a channel does not have stay empty, as in the rows of `decode`.
    const Channel& channel = cycle.sent.channel_list[k];
    const ChannelFormat& format = format_.channel_list[k];
    const bool taken = cycle.taken[k];
    cells_.push_back(taken && format.position_bits() != 0 ? Cell(channel.position) : Cell());
    cells_.push_back(taken && format.error.present ? Cell(channel.nE) : Cell());
    cells_.push_back(taken && format.warning.present ? Cell(channel.nW) : Cell());
    if (k == 0) cells_.push_back(faults_.empty() ? Cell() : Cell(faults_));
  }
  cells_.push_back(places_.empty() ? Cell() : Cell(places_));
  // No clocks: the request was not made by our master.
  cells_.push_back(cycle.reading.clocks != 0 ? Cell(cycle.reading.marginal) : Cell());
  cells_.emplace_back(cycle.sampled);
  if (!text_.empty()) cells_.emplace_back(text_);
  return cells_;
}

}  // namespace biss::verbs
