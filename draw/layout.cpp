#include "draw/layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "biss/frame/codec.hpp"
#include "decode/times.hpp"
#include "device/words.hpp"

namespace biss::draw {

namespace {

using decode::LevelChange;
using decode::shifted;
using wire::Level;

class Planner {
 public:
  Planner(const CycleDrawing& drawing, const std::optional<FrameFormat>& format, TimeText time_text)
      : drawing_(drawing), format_(format), time_text_(time_text) {
    find_edges();
  }

  std::vector<Track> tracks() {
    add_request();
    add_bits();
    add_timeout();
    std::vector<Track> tracks;
    if (!frame_.empty()) tracks.push_back({"frame", std::move(frame_)});
    if (ack_edge_ && drawing_.cycle.line_delay) {
      const Picoseconds delay = *drawing_.cycle.line_delay;
      Part part = frame_part("line delay", "line delay " + time_text_(delay), *ack_edge_,
                             shifted(*ack_edge_, delay));
      part.kind = PartKind::line;
      tracks.push_back({"delay", {std::move(part)}});
    }
    if (const auto cdm = drawing_.cycle.cdm; cdm && last_edge_ < rest_end()) {
      Part part = frame_part("CDM", *cdm ? "CDM=1" : "CDM=0", last_edge_, rest_end());
      part.value = *cdm;
      tracks.push_back({"CDM", {std::move(part)}});
    }
    return tracks;
  }

  std::vector<Mark> failures() const {
    std::vector<Mark> failures;
    const CycleStatus status = drawing_.cycle.status;
    if (status == CycleStatus::crc) {
      for (const DrawnCheck& check : drawing_.checks) {
        if (!check.right()) failures.push_back(crc_failure(check));
      }
    }
    if (failures.empty() && !is_good(status)) {
      failures.push_back(
          {place_of(status), fmt::format("{}: {}", name_of(status), text_of(status))});
    }
    return failures;
  }

 private:
  void find_edges() {
    last_edge_ = shifted(drawing_.cycle.time, drawing_.cycle.clocked);
    for (const DrawnBit& bit : drawing_.bits) {
      if (bit.clock == drawing_.cycle.ack_edge) ack_edge_ = bit.time;
      if (bit.sampled_at) last_sampled_ = &bit;
      if (bit.name == "START") start_ = &bit;
    }
    if (drawing_.cycle.release) release_ = shifted(last_edge_, *drawing_.cycle.release);
  }

  Picoseconds half() const { return drawing_.period() / 2; }
  Picoseconds begin_of(const DrawnBit& bit) const { return shifted(*bit.sampled_at, -half()); }
  Picoseconds end_of(const DrawnBit& bit) const { return shifted(*bit.sampled_at, half()); }
  Picoseconds rest_end() const { return std::min(release_.value_or(drawing_.end), drawing_.end); }
  bool is(CycleStatus status) const { return drawing_.cycle.status == status; }

  void add(Part part) {
    if (!frame_.empty()) part.from = std::max(part.from, frame_.back().to);
    if (part.from < part.to) frame_.push_back(std::move(part));
  }
  static Part frame_part(std::string_view name, std::string text, Picoseconds from, Picoseconds to,
                         bool wrong = false) {
    return {.kind = PartKind::frame,
            .text = std::move(text),
            .from = from,
            .to = to,
            .wrong = wrong,
            .name = std::string(name)};
  }

  // Up to START.
  void add_request() {
    const Picoseconds asked = ack_edge_.value_or(last_edge_);
    const bool answered = drawing_.cycle.line_delay && last_sampled_ != nullptr;
    const bool silent = is(CycleStatus::no_response) || is(CycleStatus::not_ready);
    if (!answered && !silent && !is(CycleStatus::response_range)) return;
    const Picoseconds end = answered ? shifted(asked, *drawing_.cycle.line_delay) : asked;
    add(frame_part("request", "request", drawing_.cycle.time, end));
    if (!answered) {
      if (silent) add(frame_part("no ACK", "no ACK", asked, last_edge_, true));
      return;
    }
    if (start_ == nullptr) {
      add(frame_part("ACK", "ACK", end, end_of(*last_sampled_), is(CycleStatus::no_start)));
      return;
    }
    std::string text = "ACK";
    if (drawing_.cycle.ack) text += ' ' + time_text_(*drawing_.cycle.ack);
    const std::size_t clocks = start_->clock - 1;
    text += fmt::format(", {} clock{}", clocks, clocks == 1 ? "" : "s");
    Part ack = frame_part("ACK", text, end, begin_of(*start_), is(CycleStatus::ack_range));
    ack.brief = "ACK";
    add(std::move(ack));
  }

  void add_bits() {
    for (std::size_t i = 0; i < drawing_.bits.size(); ++i) {
      const DrawnBit& bit = drawing_.bits[i];
      if (!bit.sampled_at || bit.clock < 2) continue;
      if (!bit.field.empty()) {
        const std::size_t first = i;
        while (i + 1 < drawing_.bits.size() && drawing_.bits[i + 1].sampled_at &&
               drawing_.bits[i + 1].field == bit.field) {
          ++i;
        }
        add_field(std::span(drawing_.bits).subspan(first, i + 1 - first));
      } else if (bit.name == "START") {
        add_bit(bit, bit.name, false);
      } else if (bit.name == "CDS") {
        add_bit(bit, "CDS" + level_text(bit), is(CycleStatus::cds));
      } else if (bit.name == "STOP") {
        add_bit(bit, bit.level == false ? "STOP" : "STOP" + level_text(bit),
                is(CycleStatus::stop_bit));
      }
    }
  }

  void add_bit(const DrawnBit& bit, std::string text, bool wrong) {
    Part part = frame_part(bit.name, std::move(text), begin_of(bit), end_of(bit), wrong);
    part.value = bit.level;
    add(std::move(part));
  }

  static std::string level_text(const DrawnBit& bit) {
    return !bit.level ? "=x" : *bit.level ? "=1" : "=0";
  }

  void add_field(std::span<const DrawnBit> bits) {
    const DrawnBit& first = bits.front();
    Part part{.kind = first.payload_bit && !first.data_field ? PartKind::crc
                      : is_flag(first)                       ? PartKind::flag
                                                             : PartKind::data,
              .text = first.field,
              .from = begin_of(first),
              .to = end_of(bits.back()),
              .name = first.field};
    if (first.payload_bit) {
      put_value(part, bits);
    } else {
      part.text = fmt::format("{} bits", bits.size());
    }
    add(std::move(part));
  }

  static bool is_flag(const DrawnBit& bit) { return bit.data_field && bit.data_field->is_flag(); }

  // Adds the value of these bits to a part that has the name of their field.
  void put_value(Part& part, std::span<const DrawnBit> bits) const {
    const DrawnBit& first = bits.front();
    const ChannelFormat& channel = format_->channel_list[first.channel];
    const auto& field = first.data_field;
    if (is_flag(first)) {
      const bool active_high =
          field->kind == FieldKind::error ? channel.error.active_high : channel.warning.active_high;
      part.text += level_text(first);
      part.wrong = first.level == active_high && is(CycleStatus::ok);
      part.value = first.level;
      return;
    }
    const bool padding = field && field->kind == FieldKind::padding;
    const std::size_t wanted = field ? field->place.bits : channel.crc.width_bits;
    if (bits.size() < wanted && !padding) {
      part.text += fmt::format(" ({} of {} bits)", bits.size(), wanted);
      return;
    }
    std::uint64_t value = 0;
    for (const DrawnBit& bit : bits) value = value << 1U | (bit.level == true ? 1U : 0U);
    if (field && !padding && drawing_.cycle.frame) {
      // The value of the frame, which the reader has checked.
      value = field->value(channel, drawing_.cycle.frame->channel_list[first.channel], value);
      part.text += fmt::format("={}", value);
    } else {
      part.text += fmt::format("=0x{:X}", value);
    }
    part.value = value;
    for (const DrawnCheck& check : drawing_.checks) {
      if (field || check.channel != first.channel || check.right()) continue;
      part.brief = part.text;
      part.text += fmt::format(", expected 0x{:X}", check.expected);
      part.wrong = true;
      part.expected = check.expected;
    }
  }

  void add_timeout() {
    if (!release_ || *release_ > drawing_.end) return;
    const std::string text = drawing_.cycle.release->count < 0
                                 ? "timeout"
                                 : "timeout " + time_text_(*drawing_.cycle.release);
    Part timeout = frame_part("timeout", text, last_edge_, *release_);
    timeout.brief = "timeout";
    add(std::move(timeout));
  }

  Mark crc_failure(const DrawnCheck& check) const {
    const std::string of = check.channel == 0 ? "" : fmt::format("channel {}: ", check.channel + 1);
    Mark failure{last_edge_, fmt::format("crc: {}received 0x{:X}, expected 0x{:X}", of,
                                         check.received, check.expected)};
    for (const DrawnBit& bit : drawing_.bits) {
      if (!bit.expected || bit.channel != check.channel) continue;
      failure.time = begin_of(bit);
      break;
    }
    return failure;
  }

  Picoseconds place_of(CycleStatus status) const {
    const auto sampled = [&](std::string_view name) {
      for (const DrawnBit& bit : drawing_.bits) {
        if (bit.sampled_at && bit.name == name) return *bit.sampled_at;
      }
      return last_edge_;
    };
    using enum CycleStatus;
    switch (status) {
      case no_response:
        return ack_edge_.value_or(drawing_.cycle.time);
      case response_range:
        return shifted(ack_edge_.value_or(drawing_.cycle.time),
                       drawing_.cycle.early ? -*drawing_.cycle.early : Picoseconds{});
      case ack_range:
        return sampled("START");
      case cds:
        return sampled("CDS");
      case stop_bit:
        return sampled("STOP");
      case no_start:
      case truncated:
        return last_sampled_ != nullptr ? *last_sampled_->sampled_at : last_edge_;
      case cut_end:
        return drawing_.end;
      case ma_clock:
        return uneven_edge();
      case unknown_level:
        return first_unknown();
      default:
        return drawing_.cycle.time;
    }
  }

  // The rising edge of MA with the least regular distance from the previous one.
  Picoseconds uneven_edge() const {
    Picoseconds place = drawing_.cycle.time;
    Picoseconds most{};
    for (std::size_t i = 1; i < drawing_.bits.size(); ++i) {
      const Picoseconds distance =
          decode::elapsed(drawing_.bits[i - 1].time, drawing_.bits[i].time) - drawing_.period();
      const Picoseconds off = std::max(distance, -distance);
      if (off <= most) continue;
      most = off;
      place = drawing_.bits[i].time;
    }
    return place;
  }

  Picoseconds first_unknown() const {
    Picoseconds first = drawing_.end;
    if (drawing_.slo_before == Level::unknown) first = drawing_.cycle.time;
    for (const auto* line : {&drawing_.ma, &drawing_.slo}) {
      for (const LevelChange& change : *line) {
        if (change.level == Level::unknown) first = std::min(first, change.time);
      }
    }
    return first;
  }

  std::string text_of(CycleStatus status) const {
    if (status == CycleStatus::response_range && drawing_.cycle.early) {
      return fmt::format("SLO falls {} before the second rising edge of MA",
                         time_text_(*drawing_.cycle.early));
    }
    if (status == CycleStatus::truncated && format_) {
      const auto received =
          std::count_if(drawing_.bits.begin(), drawing_.bits.end(),
                        [](const DrawnBit& bit) { return bit.payload_bit.has_value(); });
      return fmt::format("MA stops after {} of {} bits", received, format_->payload_bits());
    }
    return std::string(words_of(status).failure);
  }

  const CycleDrawing& drawing_;
  const std::optional<FrameFormat>& format_;
  TimeText time_text_;
  std::optional<Picoseconds> ack_edge_;
  Picoseconds last_edge_{};
  std::optional<Picoseconds> release_;
  const DrawnBit* start_ = nullptr;
  const DrawnBit* last_sampled_ = nullptr;
  std::vector<Part> frame_;
};

// In the order of time.
Track track_of(std::span<const Mark> marks, const CycleDrawing& drawing) {
  Track track{"marks", {}};
  for (const Mark& mark : marks) {
    if (mark.time < drawing.cycle.time || mark.time > drawing.end) continue;
    track.parts.push_back({PartKind::line, mark.text, mark.time, mark.time});
  }
  std::stable_sort(track.parts.begin(), track.parts.end(),
                   [](const Part& a, const Part& b) { return a.from < b.from; });
  return track;
}

std::string cut_text(const Cut& cut, TimeText time_text) {
  if (cut.clocks == 0) return time_text(decode::elapsed(cut.from, cut.to));
  return fmt::format("{} clock{}", cut.clocks, cut.clocks == 1 ? "" : "s");
}

}  // namespace

Layout lay_out(CycleDrawing drawing, const std::optional<FrameFormat>& format, TimeText time_text,
               std::span<const Mark> marks) {
  Layout layout;
  layout.drawing = std::move(drawing);
  const Track marked = track_of(marks, layout.drawing);
  std::vector<Picoseconds> kept;
  for (const Part& mark : marked.parts) kept.push_back(mark.from);
  layout.cuts = cuts_of(layout.drawing, kept);
  for (const Cut& cut : layout.cuts) layout.cut_texts.push_back(cut_text(cut, time_text));
  Planner planner(layout.drawing, format, time_text);
  layout.tracks = planner.tracks();
  if (!marked.parts.empty()) layout.tracks.push_back(marked);
  layout.failures = planner.failures();
  return layout;
}

std::vector<Track> tracks_of(const CycleDrawing& drawing, const std::optional<FrameFormat>& format,
                             TimeText time_text) {
  return Planner(drawing, format, time_text).tracks();
}

std::vector<Piece> pieces_of(const Track& track, const Axis& axis, std::size_t first,
                             std::size_t last) {
  std::vector<Piece> pieces;
  for (const Part& part : track.parts) {
    const std::size_t begin = axis.at(part.from);
    const std::size_t end = std::max(axis.at(part.to), begin + 1);
    if (end <= first || begin >= last || begin >= axis.ticks()) continue;
    pieces.push_back(
        {&part, std::max(begin, first) - first, std::min(end, last) - first, begin < first});
  }
  return pieces;
}

std::vector<Label> labels_of(std::span<const Piece> pieces, std::size_t (*width_of)(std::size_t),
                             std::size_t row_width) {
  std::vector<Label> labels;
  // From right to left: the label of an earlier part goes below the later labels, and the stroke
  // between part and label crosses no label.
  std::vector<std::size_t> free_until;
  for (auto piece = pieces.rbegin(); piece != pieces.rend(); ++piece) {
    const std::size_t room = piece->end - piece->begin;
    const bool is_brief = !piece->part->brief.empty() && width_of(piece->part->text.size()) > room;
    const std::string& text = is_brief ? piece->part->brief : piece->part->text;
    const std::size_t width = width_of(text.size());
    Label label{text, piece->begin, piece->begin, piece->end, 0};
    if (width <= room) {
      label.begin += (room - width) / 2;
    } else if (piece->continued) {
      continue;
    } else {
      label.begin = std::min(piece->begin, row_width - std::min(row_width, width));
      std::size_t line = 0;
      while (line < free_until.size() && free_until[line] < label.begin + width) ++line;
      free_until.resize(std::max(free_until.size(), line + 1), row_width);
      for (std::size_t each = 0; each <= line; ++each) {
        free_until[each] = std::min(free_until[each], label.begin);
      }
      label.line = line + 1;
    }
    labels.push_back(std::move(label));
  }
  return labels;
}

}  // namespace biss::draw
