#include "cli/decode/table.hpp"

#include <fmt/format.h>

namespace biss::cli {

namespace {

using report::Cell;
using report::Column;
using report::Kind;

// Channel 1 has the bare names; channel k has the same names followed by k.
std::string suffix(std::size_t k) { return k == 0 ? "" : fmt::format("{}", k + 1); }

const Channel* values_of(std::size_t k, const decode::Cycle& cycle) {
  return cycle.frame && k < cycle.frame->channel_count ? &cycle.frame->channel_list[k] : nullptr;
}

std::optional<Hertz> clock_of(const decode::Cycle& cycle) {
  return cycle.period ? std::optional(rate_of(*cycle.period)) : std::nullopt;
}

}  // namespace

DecodeTable::DecodeTable(const std::optional<FrameFormat>& format) : format_(format) {
  columns_ = {
      {.name = "cycle", .kind = Kind::unsigned_integer},
      report::time_column("time_ns", "time"),
      {.name = "status", .kind = Kind::text, .mark = report::Mark::status},
      {.name = "position", .kind = Kind::unsigned_integer},
      {.name = "nE", .kind = Kind::flag},
      {.name = "nW", .kind = Kind::flag},
      {.name = "crc_ok", .kind = Kind::flag, .heading = "CRC ok"},
      {.name = "line_delay_ns",
       .kind = Kind::nanoseconds,
       .heading = "delay",
       .unit = "ns",
       .places = 1},
      {.name = "ack_ns", .kind = Kind::nanoseconds, .heading = "ACK", .unit = "ns", .places = 0},
      {.name = "clock_hz",
       .kind = Kind::unsigned_integer,
       .heading = "clock",
       .unit = "MHz",
       .shift = 6,
       .places = 3},
      {.name = "raw", .kind = Kind::bits},
  };
  if (format_) {
    const auto channels = format_->channels();
    for (std::size_t k = 0; k < channels.size(); ++k) add_channel_columns(k, channels[k]);
  }
  columns_.push_back({.name = "marginal", .kind = Kind::flag});
  columns_.push_back({.name = "safety", .kind = Kind::text});
  columns_.push_back({.name = "limits", .kind = Kind::text});
}

void DecodeTable::add_channel_columns(std::size_t k, const ChannelFormat& channel) {
  const std::string end = suffix(k);
  if (k > 0) {
    columns_.push_back({.name = "position" + end, .kind = Kind::unsigned_integer});
    columns_.push_back({.name = "nE" + end, .kind = Kind::flag});
    columns_.push_back({.name = "nW" + end, .kind = Kind::flag});
    columns_.push_back(
        {.name = "crc" + end + "_ok", .kind = Kind::flag, .heading = "CRC" + end + " ok"});
  }
  if (channel.life_counter.present()) {
    columns_.push_back({.name = "lc" + end, .kind = Kind::unsigned_integer});
  }
  if (channel.multiturn.present()) {
    columns_.push_back({.name = "mt" + end, .kind = Kind::unsigned_integer});
    columns_.push_back({.name = "st" + end, .kind = Kind::unsigned_integer});
  }
}

// position, nE and nW: only of a good frame, and only where the channel has them.
void DecodeTable::add_values(std::size_t k, const decode::Cycle& cycle) {
  const Channel* values = values_of(k, cycle);
  if (values == nullptr) {
    cells_.insert(cells_.end(), 3, Cell());
    return;
  }
  const ChannelFormat& channel = format_->channel_list[k];
  cells_.push_back(channel.position_bits() != 0 ? Cell(values->position) : Cell());
  cells_.push_back(channel.error.present ? Cell(values->nE) : Cell());
  cells_.push_back(channel.warning.present ? Cell(values->nW) : Cell());
}

void DecodeTable::add_channel_cells(std::size_t k, const decode::Cycle& cycle) {
  if (k > 0) {
    add_values(k, cycle);
    cells_.emplace_back(cycle.crc_ok[k]);
  }
  const ChannelFormat& channel = format_->channel_list[k];
  const Channel* values = values_of(k, cycle);
  if (channel.life_counter.present()) {
    cells_.push_back(values != nullptr ? Cell(values->life_counter) : Cell());
  }
  if (!channel.multiturn.present()) return;
  if (values == nullptr) {
    cells_.insert(cells_.end(), 2, Cell());
    return;
  }
  const unsigned singleturn_bits = channel.singleturn.bits;
  cells_.emplace_back(values->position >> singleturn_bits);
  cells_.push_back(singleturn_bits != 0 ? Cell(values->position & low_mask(singleturn_bits))
                                        : Cell());
}

const std::vector<Cell>& DecodeTable::cells(std::uint64_t number, const decode::Cycle& cycle,
                                            std::optional<SafetyVerdict> safety,
                                            decode::LimitSet limits) {
  cells_.clear();
  cells_.emplace_back(number);
  cells_.emplace_back(cycle.time);
  cells_.emplace_back(decode::name_of(cycle.status));
  add_values(0, cycle);
  cells_.emplace_back(cycle.crc_ok[0]);
  cells_.emplace_back(cycle.line_delay);
  cells_.emplace_back(cycle.ack);
  cells_.emplace_back(clock_of(cycle));
  cells_.push_back(cycle.raw.size_bits() != 0 ? Cell(cycle.raw.view()) : Cell());
  if (format_) {
    for (std::size_t k = 0; k < format_->channel_count; ++k) add_channel_cells(k, cycle);
  }
  cells_.emplace_back(cycle.marginal);
  cells_.push_back(safety ? Cell(name_of(*safety)) : Cell());
  limits_ = decode::text_of(limits);
  cells_.push_back(limits_.empty() ? Cell() : Cell(limits_));
  return cells_;
}

}  // namespace biss::cli
