#include "rows/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "biss/frame/line_order.hpp"
#include "rows/columns.hpp"

namespace biss::rows {

namespace {

using report::Cell;
using report::Column;
using report::Kind;
using report::Role;

// Channel 1 has the bare names; channel k has the same names followed by k.
std::string suffix(std::size_t k) { return k == 0 ? "" : fmt::format("{}", k + 1); }

const Channel* values_of(std::size_t k, const decode::Cycle& cycle) {
  return cycle.frame && k < cycle.frame->channel_count ? &cycle.frame->channel_list[k] : nullptr;
}

std::optional<Hertz> clock_of(const decode::Cycle& cycle) {
  return cycle.period ? std::optional(rate_of(*cycle.period)) : std::nullopt;
}

}  // namespace

DecodeTable::DecodeTable(const std::optional<FrameFormat>& format, bool format_varies,
                         MotionColumns motion, bool frame_track)
    : format_(format),
      format_varies_(format_varies),
      motion_(std::move(motion)),
      frame_track_(frame_track) {
  const bool fixed = format_ && !format_varies_;
  columns_ = {
      {.name = "cycle", .kind = Kind::unsigned_integer, .bits = 53},
      report::time_column("time_ns", "time"),
      {.name = "status", .role = Role::status, .title = "Status"},
  };
  add_value_columns(0, format_ ? format_->channel_list[0].position_bits() : 1);
  columns_.push_back(line_delay_column());
  columns_.push_back(ack_column());
  columns_.push_back(clock_column());
  columns_.push_back(
      {.name = "raw",
       .kind = Kind::bits,
       .bits = fixed ? format_->payload_bits() + 3 : unsigned{decode::RawBits::capacity_bits}});
  if (format_) {
    const auto channels = format_->channels();
    for (std::size_t k = 0; k < channels.size(); ++k) add_channel_columns(k, channels[k]);
    channels_ = channels.size();
    first_channel_ = channels[0];
  }
  columns_.push_back(
      {.name = "marginal", .kind = Kind::flag, .role = Role::warning_at_1, .title = "Sampling"});
  columns_.push_back({.name = "safety", .role = Role::verdict, .title = "Safety monitor"});
  columns_.push_back({.name = "limits", .role = Role::warnings, .title = "Limits of the encoder"});
  add_motion_columns();
  if (frame_track_) columns_.push_back({.name = "frame"});
  cells_.resize(columns_.size());
  for (std::size_t set = 0; set < limit_texts_.size(); ++set) {
    limit_texts_[set] = decode::text_of(static_cast<decode::LimitSet>(set));
  }
}

Column DecodeTable::integer(std::string name, unsigned bits, std::string unit) const {
  return {.name = std::move(name),
          .kind = Kind::unsigned_integer,
          .bits = format_varies_ ? 0 : bits,
          .value_unit = std::move(unit)};
}

void DecodeTable::add_motion_columns() {
  const std::string unit = motion_.unit.empty() ? "counts" : motion_.unit;
  if (motion_.unwrap) {
    columns_.push_back({.name = "unwrapped", .kind = Kind::signed_integer, .value_unit = "counts"});
  }
  if (!motion_.unit.empty()) {
    columns_.push_back({.name = "position_" + unit,
                        .kind = Kind::real,
                        .unit = unit,
                        .value_unit = unit,
                        .title = "Position",
                        .plot = 1});
  }
  if (motion_.velocity) {
    columns_.push_back({.name = "velocity_" + unit + "_s",
                        .kind = Kind::real,
                        .heading = "velocity",
                        .unit = unit + "/s",
                        .value_unit = unit + "/s",
                        .title = "Velocity",
                        .plot = 2});
  }
}

void DecodeTable::add_value_columns(std::size_t k, unsigned position_bits) {
  const std::string end = suffix(k);
  const auto add_flag = [&](std::string name, std::string heading, Role role, std::string title) {
    columns_.push_back({.name = std::move(name),
                        .kind = Kind::flag,
                        .heading = std::move(heading),
                        .role = role,
                        .title = std::move(title)});
  };
  Column& position = columns_.emplace_back(integer("position" + end, position_bits, "counts"));
  position.title = k == 0 ? "Position" : "Position of channel " + end;
  // One with a unit is plotted instead.
  position.plot = k > 0 ? 3 : motion_.unit.empty() ? 1 : 0;
  add_flag("nE" + end, "", Role::error_at_0, "Flags of the encoder");
  add_flag("nW" + end, "", Role::warning_at_0, "Flags of the encoder");
  add_flag("crc" + end + "_ok", "CRC" + end + " ok", Role::check_at_0, "Checksums");
}

void DecodeTable::add_channel_columns(std::size_t k, const ChannelFormat& channel) {
  const std::string end = suffix(k);
  if (k > 0) add_value_columns(k, channel.position_bits());
  if (channel.life_counter.present()) {
    columns_.push_back(integer("lc" + end, channel.life_counter.bits, ""));
  }
  if (channel.multiturn.present()) {
    columns_.push_back(integer("mt" + end, channel.multiturn.bits, "turns"));
    columns_.push_back(
        integer("st" + end, std::max(channel.singleturn.bits, std::uint8_t{1}), "counts"));
  }
}

// position, nE and nW: only for a good frame, and only if the channel has them.
Cell* DecodeTable::put_values(Cell* at, const ChannelFormat& channel, const Channel* values) {
  const bool known = values != nullptr;
  *at++ = known && channel.position_bits() != 0 ? Cell(values->position) : Cell();
  *at++ = known && channel.error.present ? Cell(values->nE) : Cell();
  *at++ = known && channel.warning.present ? Cell(values->nW) : Cell();
  return at;
}

Cell* DecodeTable::put_channel(Cell* at, std::size_t k, const decode::Cycle& cycle) const {
  const ChannelFormat& channel = format_->channel_list[k];
  const Channel* values = values_of(k, cycle);
  if (k > 0) {
    at = put_values(at, channel, values);
    *at++ = cycle.crc_ok[k];
  }
  if (channel.life_counter.present()) {
    *at++ = values != nullptr ? Cell(values->life_counter) : Cell();
  }
  if (channel.multiturn.present()) {
    const unsigned singleturn_bits = channel.singleturn.bits;
    const bool has_singleturn = values != nullptr && singleturn_bits != 0;
    *at++ = values != nullptr ? Cell(values->position >> singleturn_bits) : Cell();
    *at++ = has_singleturn ? Cell(values->position & low_mask(singleturn_bits)) : Cell();
  }
  return at;
}

const std::vector<Cell>& DecodeTable::cells(std::uint64_t number, const decode::Cycle& cycle,
                                            std::optional<SafetyVerdict> safety,
                                            decode::LimitSet limits, const MotionValues& motion,
                                            bool timed) {
  Cell* at = cells_.data();
  *at++ = number;
  *at++ = timed ? Cell(cycle.time) : Cell();
  *at++ = name_of(cycle.status);
  at = put_values(at, first_channel_, values_of(0, cycle));
  *at++ = cycle.crc_ok[0];
  *at++ = cycle.line_delay;
  *at++ = cycle.ack;
  *at++ = clock_of(cycle);
  *at++ = cycle.raw.size_bits() != 0 ? Cell(cycle.raw.view()) : Cell();
  for (std::size_t k = 0; k < channels_; ++k) at = put_channel(at, k, cycle);
  *at++ = cycle.marginal;
  *at++ = safety ? Cell(name_of(*safety)) : Cell();
  *at++ = limits != 0 ? Cell(limit_texts_[limits]) : Cell();
  if (motion_.unwrap) *at++ = motion.unwrapped;
  if (!motion_.unit.empty()) *at++ = motion.scaled;
  if (motion_.velocity) *at++ = motion.velocity;
  if (frame_track_) {
    frame_text_ = frame_text(cycle);
    *at++ = Cell(frame_text_);
  }
  return cells_;
}

// The cause, if there is one, and the parts of the frame in line order. In a frame that is not
// good, the values are the bits as received.
std::string DecodeTable::frame_text(const decode::Cycle& cycle) const {
  std::string text;
  if (cycle.status != CycleStatus::ok) text = name_of(cycle.status);
  const BitView raw = cycle.raw.view();
  std::size_t at = 2;  // after START and CDS
  for (std::size_t k = 0; k < channels_; ++k) {
    const ChannelFormat& channel = format_->channel_list[k];
    if (at + channel.total_bits() > raw.size_bits()) break;
    const std::uint64_t data = raw.word(at, channel.data_bits);
    const Channel* values = values_of(k, cycle);
    const auto add = [&](std::string_view name, std::string value) {
      text += fmt::format("{}{}{}={}", text.empty() ? "" : " ", name, suffix(k), value);
    };
    for_each_field(channel, [&](const LineField& field) {
      if (field.kind == FieldKind::padding) return;
      const bool known = values != nullptr || field.is_flag();
      add(field.name,
          known ? fmt::format("{}", values != nullptr ? field.value(channel, *values, data)
                                                      : field.place.of(data))
                : fmt::format("0x{:X}", field.place.of(data)));
    });
    if (channel.crc.present()) {
      add("crc", fmt::format("0x{:X}", raw.word(at + channel.data_bits, channel.crc.width_bits)));
    }
    at += channel.total_bits();
  }
  return text;
}

}  // namespace biss::rows
