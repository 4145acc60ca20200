#include "draw/cycle_drawing.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "biss/frame/codec.hpp"
#include "biss/frame/line_order.hpp"
#include "decode/times.hpp"

namespace biss::draw {

namespace {

using decode::CycleEdges;
using decode::LevelChange;
using wire::Level;

// SLO is drawn for this many periods after the last edge of MA and of SLO's bits.
constexpr std::int64_t periods_after = 2;

// Names the bits after CDS: data and CRC in the order of the line, and STOP.
void name_payload(std::span<DrawnBit> bits, const FrameFormat& format) {
  std::size_t next = 0;
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    const std::string suffix = k == 0 ? "" : '.' + std::to_string(k + 1);
    const auto add = [&](std::string_view field, const std::string& number,
                         const std::optional<LineField>& data_field) {
      if (next == bits.size()) return;
      DrawnBit& bit = bits[next];
      bit.name = std::string(field) + number + suffix;
      bit.field = std::string(field) + suffix;
      bit.payload_bit = next++;
      bit.channel = k;
      bit.data_field = data_field;
    };
    for_each_field(channel, [&](const LineField& field) {
      const bool numbered = !field.is_flag() && field.kind != FieldKind::padding;
      for (unsigned bit = field.place.bits; bit-- > 0;) {
        const unsigned number = field.lsb ? field.place.bits - 1U - bit : bit;
        add(field.name, numbered ? std::to_string(number) : "", field);
      }
    });
    for (unsigned bit = channel.crc.width_bits; bit-- > 0;) add("crc", std::to_string(bit), {});
  }
  if (next < bits.size()) bits[next].name = "STOP";
}

// How the CRC changes when one bit of the channel is inverted, data first.
std::vector<std::uint16_t> changes_of(const PlainCodec& codec, std::size_t k, bool cds) {
  const ChannelFormat& channel = codec.format().channel_list[k];
  std::vector<std::uint16_t> changes;
  const std::uint16_t none = codec.crc(k, 0, cds);
  for (unsigned shift = channel.data_bits; shift-- > 0;) {
    changes.push_back(
        static_cast<std::uint16_t>(codec.crc(k, std::uint64_t{1} << shift, cds) ^ none));
  }
  for (unsigned bit = channel.crc.width_bits; bit-- > 0;) {
    changes.push_back(static_cast<std::uint16_t>(1U << bit));
  }
  return changes;
}

// Which flips correct a CRC that is wrong by `difference`. \param first bit of the channel
void find_flips(const std::vector<std::uint16_t>& changes, std::uint16_t difference,
                std::size_t first, DrawnCheck& check) {
  for (std::size_t i = 0; i < changes.size(); ++i) {
    if (changes[i] == difference) check.singles.push_back({first + i});
    for (std::size_t j = i + 1; j < changes.size(); ++j) {
      if ((changes[i] ^ changes[j]) != difference) continue;
      if (check.pair_count++ < drawn_pairs) check.pairs.push_back({first + i, first + j});
    }
  }
}

std::vector<DrawnCheck> checks_of(BitView raw, const FrameFormat& format) {
  std::vector<DrawnCheck> checks;
  const PlainCodec codec(format);
  std::size_t at = 0;
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    // START and CDS come before.
    if (at + 2 + channel.total_bits() > raw.size_bits()) break;
    // The checksum of the previous frame does not cover these bits.
    if (channel.crc.present() && !channel.crc.of_previous) {
      const std::uint64_t data = raw.word(at + 2, channel.data_bits);
      DrawnCheck check{.channel = k,
                       .received = static_cast<std::uint16_t>(
                           raw.word(at + 2 + channel.data_bits, channel.crc.width_bits)),
                       .expected = codec.crc(k, data, raw[1]),
                       .singles = {},
                       .pairs = {}};
      if (!check.right()) {
        find_flips(changes_of(codec, k, raw[1]),
                   static_cast<std::uint16_t>(check.received ^ check.expected), at, check);
      }
      checks.push_back(std::move(check));
    }
    at += channel.total_bits();
  }
  return checks;
}

Level level_at(const std::vector<LevelChange>& changes, Level before, Picoseconds time) {
  const auto after =
      std::upper_bound(changes.begin(), changes.end(), time,
                       [](Picoseconds at, const LevelChange& change) { return at < change.time; });
  return after == changes.begin() ? before : std::prev(after)->level;
}

class Drawer {
 public:
  Drawer(const CycleEdges& edges, const std::optional<FrameFormat>& format,
         const DeviceTiming& timing, const decode::MarginSetup& margin, DrawnExtent extent)
      : edges_(edges), format_(format), reader_(format, timing, margin), extent_(extent) {}

  CycleDrawing run() {
    drawing_.number = edges_.number;
    drawing_.cycle = edges_.cycle;
    drawing_.slo_before = edges_.slo_before;
    if (!edges_.ma.empty() && edges_.ma.front().level == Level::high) {
      drawing_.ma_before = Level::low;
    }
    drawing_.cycle.raw = read_again(edges_, reader_).cycle.raw;
    sampled_ = reader_.sample_times();
    copy_edges();
    add_bits();
    if (format_) drawing_.checks = checks_of(drawing_.cycle.raw.view(), *format_);
    add_expected();
    return std::move(drawing_);
  }

 private:
  void copy_edges() {
    Picoseconds last = edges_.ma.empty() ? edges_.cycle.time : edges_.ma.back().time;
    if (!sampled_.empty()) last = std::max(last, sampled_.back());
    if (extent_ == DrawnExtent::cycle) {
      if (!edges_.ma_after.empty()) last = std::max(last, edges_.ma_after.back().time);
      if (!edges_.slo.empty()) last = std::max(last, edges_.slo.back().time);
    }
    drawing_.end = std::min(decode::shifted(last, periods_after * drawing_.period()),
                            std::max(edges_.limit, last));
    const auto copy = [&](std::span<const LevelChange> from, std::vector<LevelChange>& to) {
      for (const LevelChange& change : from) {
        if (change.time <= drawing_.end) to.push_back(change);
      }
    };
    copy(edges_.ma, drawing_.ma);
    copy(edges_.ma_after, drawing_.ma);
    copy(edges_.slo, drawing_.slo);
  }

  void add_bits() {
    std::size_t clock = 0;
    for (const LevelChange& change : edges_.ma) {
      if (change.level != Level::high) continue;
      DrawnBit bit;
      bit.clock = clock;
      bit.time = change.time;
      if (clock < sampled_.size()) {
        bit.sampled_at = sampled_[clock];
        const Level level = level_at(drawing_.slo, drawing_.slo_before, *bit.sampled_at);
        if (level != Level::unknown) bit.level = level == Level::high;
        // The reader has found ACK there, with any level of the sample.
        if (clock <= 1) bit.level = clock == 0;
      }
      drawing_.bits.push_back(std::move(bit));
      ++clock;
    }
    name_bits();
  }

  // ACK lasts until the first 1 after it.
  void name_bits() {
    const BitView raw = drawing_.cycle.raw.view();
    if (!drawing_.bits.empty()) drawing_.bits.front().name = "LAT";
    const auto bits =
        std::span(drawing_.bits).first(std::min(drawing_.bits.size(), sampled_.size()));
    std::size_t start = 2;
    while (start < bits.size() && (bits[start].level != true || raw.empty())) ++start;
    for (std::size_t i = 1; i < std::min(start, bits.size()); ++i) bits[i].name = "ACK";
    if (start >= bits.size()) return;
    // The reader's bits count.
    for (std::size_t i = 0; start + i < bits.size() && i < raw.size_bits(); ++i) {
      bits[start + i].level = raw[i];
    }
    bits[start].name = "START";
    if (start + 1 == bits.size()) return;
    bits[start + 1].name = "CDS";
    const auto payload = bits.subspan(start + 2);
    if (format_) return name_payload(payload, *format_);
    for (DrawnBit& bit : payload) {
      bit.name = "bit";
      bit.field = "bits";
    }
  }

  void add_expected() {
    for (const DrawnCheck& check : drawing_.checks) {
      unsigned left = format_->channel_list[check.channel].crc.width_bits;
      for (DrawnBit& bit : drawing_.bits) {
        const bool of_crc = bit.payload_bit && !bit.data_field && bit.channel == check.channel;
        if (of_crc) bit.expected = ((check.expected >> --left) & 1U) != 0;
      }
    }
  }

  const CycleEdges& edges_;
  const std::optional<FrameFormat>& format_;
  decode::CycleReader reader_;
  DrawnExtent extent_;
  std::vector<Picoseconds> sampled_;
  CycleDrawing drawing_;
};

}  // namespace

std::string_view CycleDrawing::name_of(std::size_t payload_bit) const {
  for (const DrawnBit& bit : bits) {
    if (bit.payload_bit == payload_bit) return bit.name;
  }
  return {};
}

CycleDrawing draw_cycle(const CycleEdges& edges, const std::optional<FrameFormat>& format,
                        const DeviceTiming& timing, const decode::MarginSetup& margin,
                        DrawnExtent extent) {
  return Drawer(edges, format, timing, margin, extent).run();
}

}  // namespace biss::draw
