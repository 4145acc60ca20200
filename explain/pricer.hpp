// The price of each kind for the requests of a capture.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "biss/frame/codec.hpp"
#include "decode/cycle.hpp"
#include "decode/cycle_edges.hpp"
#include "decode/times.hpp"
#include "explain/request.hpp"

namespace biss::explain {

/// Prices the requests of a capture in their order.
class Pricer {
  using Cycle = decode::Cycle;
  using CycleEdges = decode::CycleEdges;
  using Kind = RequestKind;
  using Level = wire::Level;
  using LevelChange = decode::LevelChange;

 public:
  Pricer(const std::optional<FrameFormat>& format, Picoseconds resolution, const Usual& usual)
      : resolution_(resolution), usual_(usual) {
    if (format) {
      codec_.emplace(*format);
      std::size_t at = 2;
      for (const ChannelFormat& channel : format->channels()) {
        channels_.push_back({channel, at});
        at += channel.total_bits();
      }
      return;
    }
    // All bits are a position.
    ChannelFormat all;
    all.data_bits = all.position.bits =
        static_cast<std::uint8_t>(std::min(usual.payload_bits, 63U));
    channels_.push_back({all, 2});
  }

  /// A good frame with nothing unusual that Cycle shows: it is `ok`, and its edges need not be seen.
  bool is_plain(const Cycle& cycle) const {
    if (!is_good(cycle.status) || !cycle.line_delay || !cycle.period) return false;
    if (cycle.frame && !cycle.frame->trusted()) return false;
    const Picoseconds period = usual_.period;
    const Picoseconds doubt = 2 * resolution_;
    const Picoseconds off = *cycle.line_delay - usual_.delay;
    const Picoseconds tolerance = tolerance_of_grid(period);
    if (std::max(off, -off) > tolerance) return false;
    // MA may pause for a part of a period. Its last edge rises, or falls if MA rests low.
    const auto clocked = std::int64_t{cycle.rising_edges} * *cycle.period -
                         (cycle.cdm == true ? Picoseconds{} : *cycle.period / 2);
    if (cycle.pauses != 0 || cycle.clocked > clocked + 2 * *cycle.period / 5 + resolution_ ||
        4 * *cycle.period > 5 * (period + doubt)) {
      return false;
    }
    // From STOP on, SLO is low until MA rests.
    const std::size_t stop = usual_.payload_bits + std::size_t{2};
    if (!cycle.frame) {
      if (usual_.checksum) return false;
      const BitView raw = cycle.raw.view();
      if (raw.size_bits() <= stop || raw.find(true, stop) != raw.size_bits()) return false;
    } else if (cycle.rising_edges > cycle.frame->ack_clocks + stop + 2 &&
               (!cycle.release || *cycle.release < Picoseconds{})) {
      return false;
    }
    if (!cycle.signal) return true;
    if (cycle.signal->ma_pulses + cycle.signal->slo_pulses != 0) return false;
    if (!cycle.signal->changes) return true;
    return cycle.signal->changes->latest - usual_.delay <= tolerance &&
           usual_.delay - cycle.signal->changes->earliest <= tolerance;
  }

  /// The next request is plain.
  void learn(const Cycle& cycle) {
    if (const auto rest = rest_before(cycle)) {
      shortest_rest_ = std::min(*rest, shortest_rest_.value_or(*rest));
    }
    // From a good frame to a good frame.
    if (last_request_ && was_good_) {
      const Picoseconds interval = decode::elapsed(*last_request_, cycle.time);
      if (5 * interval < 4 * interval_ || intervals_ == 0) {
        interval_ = interval;
        intervals_ = regular_ = 0;
      }
      ++intervals_;
      if (4 * interval <= 5 * interval_) ++regular_;
    }
    last_request_ = cycle.time;
    was_good_ = true;
    last_edge_ = decode::shifted(cycle.time, cycle.clocked);
    was_part_ = false;
    fewest_clocks_ = std::min(fewest_clocks_, cycle.rising_edges);
    ++frames_;
    std::uint16_t ack = 0;
    if (cycle.frame) {
      ack = cycle.frame->ack_clocks;
      for (std::size_t k = 0; k < cycle.frame->channel_count; ++k) {
        const std::uint64_t position = cycle.frame->channel_list[k].position;
        steps_[k] = position - std::exchange(data_[k], position);
      }
      step_time_ = decode::elapsed(std::exchange(data_time_, cycle.time), cycle.time);
    } else {
      if (cycle.ack && cycle.period) {
        ack = static_cast<std::uint16_t>(decode::periods_in(*cycle.ack, *cycle.period));
      }
      data_[0] = position_of(cycle.raw.view(), channels_[0]);
    }
    before_ = cycle.raw;
    longest_ack_ = std::max(longest_ack_, ack);
    ++acks_[std::min<std::size_t>(ack, acks_.size() - 1)];
  }

  /// The next request is not. \param thorough also looks for one wrong bit or clock, which is slow
  const Prices& read(const CycleEdges& edges, bool thorough = true) {
    thorough_ = thorough;
    prices_.fill(impossible);
    count_pulses(edges);
    look(edges, usual_.delay);
    const auto clocks = static_cast<float>(view_.clocks());
    set(Kind::literal, clocks + edge_price * view_.off_grid + 6 +
                           pause_price * static_cast<float>(view_.pauses != 0));
    if (last_.size_bits() != 0) {
      const auto [value, size] = number_of(view_.bits.view(), SIZE_MAX);
      const auto [last, last_size] = number_of(last_.view(), SIZE_MAX);
      const float change = size == last_size ? change_price(last, value, size) : clocks;
      set(Kind::foreign,
          change + clocks - static_cast<float>(size) + 3 + edge_price * view_.off_grid);
    }
    last_ = view_.bits;
    const bool low = edges.slo_before == Level::low;
    if (edges.cycle.status == CycleStatus::ma_glitch) {
      set(Kind::ma_pulse, 6);
    } else if (low) {
      price_low(edges);
    } else if (edges.slo.empty()) {
      set(Kind::silent, 0.5F);
    } else {
      price_frame(edges);
      // The encoder takes this request for a part of the one before.
      const auto rest = rest_before(edges.cycle);
      if (rest && shortest_rest_ && 10 * *rest < 9 * *shortest_rest_) {
        set(Kind::hurried, 8 + clocks / 4);
      }
    }
    if (edges.cycle.status == CycleStatus::ack_range) {
      float& good = price(Kind::ok);
      if (good < impossible) set(Kind::other_ack, std::exchange(good, impossible));
    }
    last_request_ = edges.cycle.time;
    was_good_ = false;
    last_edge_ = decode::shifted(edges.cycle.time, edges.cycle.clocked);
    was_part_ = price(Kind::restart) < impossible;
    if (!low && view_.start + 2 < view_.clocks()) {
      ++frames_;
      ++acks_[std::min(view_.ack_clocks(), acks_.size() - 1)];
      before_ = {};
      before_.append(view_.frame());
    }
    return prices_;
  }

  /// From the last edge of MA before to this request.
  std::optional<Picoseconds> rest_before(const Cycle& cycle) const {
    if (!last_edge_ || *last_edge_ > cycle.time) return std::nullopt;
    return decode::elapsed(*last_edge_, cycle.time);
  }

  /// In the request read last.
  unsigned ma_pulses() const { return view_.ma_pulses; }
  unsigned slo_pulses() const { return view_.slo_pulses; }
  Picoseconds smear() const { return view_.smear; }
  /// Its checksum is wrong, and its position is near the position of the frame before.
  bool position_is_likely() const { return view_.likely; }
  /// By its bits, which no checksum proves, the encoder reports an error.
  bool shows_error() const {
    const BitView bits = view_.frame();
    return std::any_of(channels_.begin(), channels_.end(), [&](const Place& place) {
      const FlagField& error = place.format.error;
      const std::size_t at = place.at + place.format.data_bits - 1 - error.shift;
      return error.present && at < bits.size_bits() && bits[at] == error.active_high;
    });
  }

 private:
  // A level of SLO shorter than a period over this is a pulse, and one of MA shorter than this share
  // of its usual length, in per cent.
  static constexpr std::int64_t pulse_share = 5;
  static constexpr std::int64_t pulse_percent = 60;
  // Clocks further apart than this, in per cent of a period, have a pause between them.
  static constexpr std::int64_t pause_percent = 140;
  // Prices in bits; docs/explain.md explains each of them.
  static constexpr float edge_price = 12;
  static constexpr float flip_edge_price = 6;
  static constexpr float pause_price = 7;
  static constexpr float one_price = 5;
  static constexpr std::size_t least_ones = 4;
  static constexpr std::size_t least_zeros = 11;
  static constexpr std::size_t least_length = 9;

  using Bits = FrameBits;
  // A channel, and its first bit, counted from START.
  struct Place {
    ChannelFormat format;
    std::size_t at = 0;
  };
  // A request as a master reads it that knows the line delay.
  struct View {
    std::vector<Picoseconds> rises;
    Picoseconds time{};
    Picoseconds period{};
    unsigned ma_pulses = 0;
    unsigned slo_pulses = 0;
    unsigned pulses_in_bits = 0;
    unsigned pauses = 0;
    // SLO changes in a pause.
    bool gave_up = false;
    // Changes of SLO that are not at the beginning of a bit.
    float off_grid = 0;
    Picoseconds smear{};
    bool likely = false;
    Bits bits;
    // Indexes of ACK and START; past the end if missing.
    std::size_t ack = 0;
    std::size_t start = 0;

    std::size_t clocks() const { return rises.size(); }
    // From START on.
    BitView frame() const { return bits.view().from(start); }
    std::size_t ack_clocks() const { return start - ack; }
  };

  static float bits_of(double number) {
    return static_cast<float>(std::log2(std::max(number, 1.0)));
  }
  static float count_price(std::size_t number) { return bits_of(static_cast<double>(number)); }

  // A number of `bits` bits, by its change.
  static float change_price(std::uint64_t before, std::uint64_t now, unsigned bits) {
    const std::uint64_t change =
        std::min((now - before) & low_mask(bits), (before - now) & low_mask(bits));
    return std::min(static_cast<float>(bits) + 1, 2 * bits_of(static_cast<double>(change) + 1) + 2);
  }

  // The first of these bits as a number, and how many these are.
  static std::pair<std::uint64_t, unsigned> number_of(BitView bits, std::size_t most) {
    const auto size = static_cast<unsigned>(std::min<std::size_t>({most, bits.size_bits(), 63}));
    return {bits.word(0, size), size};
  }

  static std::size_t tail_of(BitView bits, bool level) {
    std::size_t tail = 0;
    while (tail < bits.size_bits() && bits[bits.size_bits() - 1 - tail] == level) ++tail;
    return tail;
  }

  // A change of SLO belongs to the grid of the bits within this share of a period, and samples.
  Picoseconds tolerance_of_grid(Picoseconds period) const {
    return period * 16 / 100 + resolution_ * 16 / 10;
  }

  float& price(Kind kind) { return prices_[static_cast<std::size_t>(kind)]; }
  void set(Kind kind, float bits) { price(kind) = std::min(price(kind), bits); }

  void look(const CycleEdges& edges, Picoseconds delay) {
    const Picoseconds half = view_.period / 2;
    view_.bits.clear();
    std::size_t next = 0;
    Level level = edges.slo_before;
    unsigned pulses = 0;
    for (const Picoseconds rise : view_.rises) {
      const Picoseconds sample = decode::shifted(rise, delay + half);
      const std::size_t first = next;
      while (next < edges.slo.size() && edges.slo[next].time <= sample) {
        level = edges.slo[next++].level;
      }
      // Between two bits of a good frame, SLO changes once at most.
      pulses += static_cast<unsigned>(next - first) / 2;
      view_.bits.append(level != Level::low);
    }
    view_.pulses_in_bits = pulses;
    view_.ack = view_.bits.view().find(false, 0);
    view_.start = view_.bits.view().find(true, view_.ack);
    view_.off_grid = 0;
    view_.smear = {};
    if (view_.rises.size() < 2) return;
    const std::size_t end = std::min(view_.clocks() - 1, view_.start + 2 + usual_.payload_bits);
    const Picoseconds last = decode::shifted(view_.rises[end], delay + half);
    const Picoseconds tolerance = tolerance_of_grid(view_.period);
    for (const LevelChange& change : edges.slo) {
      if (change.time > last) break;
      const Picoseconds moved = decode::shifted(change.time, -delay);
      const auto after = std::lower_bound(view_.rises.begin() + 1, view_.rises.end(), moved);
      Picoseconds off = after == view_.rises.end() ? moved - view_.rises.back()
                                                   : std::max(*after - moved, moved - *after);
      if (after != view_.rises.begin() + 1) {
        off = std::min(off, std::max(moved - *(after - 1), *(after - 1) - moved));
      }
      view_.smear = std::max(view_.smear, off);
      if (off > tolerance) ++view_.off_grid;
    }
  }

  void count_pulses(const CycleEdges& edges) {
    view_ = {};
    view_.time = edges.cycle.time;
    view_.period = edges.cycle.period.value_or(usual_.period);
    const auto is_short = [&](Picoseconds from, Picoseconds to) {
      return pulse_share * (decode::elapsed(from, to) + resolution_) < view_.period;
    };
    std::vector<LevelChange> ma(edges.ma.begin(), edges.ma.end());
    remove_pulses(ma);
    for (const LevelChange& change : ma) {
      const bool fits = view_.rises.size() < Bits::capacity_bits;
      if (change.level == Level::high && fits) view_.rises.push_back(change.time);
    }
    for (std::size_t i = 1; i < view_.rises.size(); ++i) {
      const Picoseconds gap = decode::elapsed(view_.rises[i - 1], view_.rises[i]);
      if (100 * gap <= pause_percent * view_.period + 100 * resolution_) continue;
      ++view_.pauses;
      // The encoder's timeout ends within the pause, and SLO rises.
      const Picoseconds moved = usual_.delay + view_.period / 4 + resolution_;
      const Picoseconds from = decode::shifted(view_.rises[i - 1], moved);
      const Picoseconds to = decode::shifted(view_.rises[i], usual_.delay - view_.period / 4);
      view_.gave_up = view_.gave_up || std::any_of(edges.slo.begin(), edges.slo.end(),
                                                   [&](const LevelChange& change) {
                                                     return from < change.time && change.time < to;
                                                   });
    }
    for (std::size_t i = 1; i < edges.slo.size(); ++i) {
      if (is_short(edges.slo[i - 1].time, edges.slo[i].time)) ++view_.slo_pulses;
    }
  }

  // The shortest level first: what it interrupts is whole again then.
  void remove_pulses(std::vector<LevelChange>& ma) {
    constexpr unsigned most_pulses = 64;
    while (view_.ma_pulses < most_pulses) {
      std::size_t shortest = 0;
      std::int64_t least = pulse_percent;
      for (std::size_t i = 1; i < ma.size(); ++i) {
        const bool high = ma[i - 1].level == Level::high;
        const Picoseconds usual = high ? usual_.high : usual_.period - usual_.high;
        const Picoseconds length = decode::elapsed(ma[i - 1].time, ma[i].time) + 2 * resolution_;
        const std::int64_t percent = 100 * length.count / std::max<std::int64_t>(usual.count, 1);
        if (percent >= least) continue;
        least = percent;
        shortest = i;
      }
      if (shortest == 0) return;
      ++view_.ma_pulses;
      const auto at = ma.begin() + static_cast<std::ptrdiff_t>(shortest);
      ma.erase(at - 1, at + 1);
    }
  }

  void price_frame(const CycleEdges& edges) {
    const BitView bits = view_.bits.view();
    const std::size_t size = view_.clocks();
    const std::size_t start = view_.start;
    // Reduced frames have LAT and ACK alone, short ones no channel.
    const bool reduced = size == 2 && view_.ack == 1;
    if ((reduced || is_brief()) && view_.off_grid == 0) set(Kind::short_frame, 1);
    if (view_.ack != 1 || edges.cycle.early) return price_moved(edges);
    if (start >= size) {
      const float price = 2 + edge_price * view_.off_grid;
      set(Kind::cut_in_ack, price);
      if (is_part(edges)) set(Kind::restart, price);
      if (is_held(edges)) set(Kind::ma_held, price - 1);
      return price_tails();
    }
    const std::size_t stop = start + 2 + usual_.payload_bits;
    // After STOP, SLO is low.
    float ones = 0;
    for (std::size_t i = stop + 1; codec_ && i < size; ++i) ones += bits[i] ? one_price : 0;
    const float base = ack_price(view_.ack_clocks()) + data_price(view_.frame()) + ones;
    if (size < stop) {
      price_cut(edges);
      price_tails();
      price_length();
      return price_moved(edges);
    }
    if (!codec_) {
      if (size == stop) price_cut(edges);
      if (bits.find(true, stop) == size) {
        Frame frame;
        // The bits of the checksum are no longer free.
        if (usual_.checksum) price_checksum(base - usual_.checksum->channel.crc.width_bits + 2);
        // A frame whose STOP is not seen may be longer, or its last bit is there in place of STOP.
        price_good(frame, size == stop ? base + 4 : base);
        if (size == stop && bits[size - 1] == bits[size - 2]) {
          set(Kind::stop_repeats, base);
        }
      } else {
        price_length();
        set(Kind::flip, base + count_price(size));
        price_tails();
        price_moved(edges);
      }
      return;
    }
    const auto frame = judge(bits);
    if (frame.ok()) {
      // Another channel follows, whose first bit is 0.
      if (ones != 0) set(Kind::stop_high, base - ones + 2);
      return price_good(*frame, base);
    }
    price_moved(edges);
    if (frame.error().cause != FrameError::stop_bit) price_length();
    price_wrong(frame.error().cause, base, ones);
  }

  void price_good(const Frame& frame, float base) {
    remember();
    const float off = view_.off_grid;
    const bool trusted = !codec_ || frame.trusted();
    float good = base + edge_price * off + (view_.pauses != 0 ? pause_price : 0.0F) +
                 10 * static_cast<float>(view_.ma_pulses);
    set(trusted ? Kind::ok : Kind::error_flag, good);
    if (view_.pauses != 0) set(Kind::paused, base + 1 + edge_price * off);
    const auto pulses = static_cast<float>(std::max(view_.slo_pulses, view_.pulses_in_bits));
    const float moved = std::max(off - 2 * pulses, 0.0F);
    if (pulses != 0) set(Kind::slo_pulse, base + 4 + 4 * pulses + edge_price * moved);
    if (view_.ma_pulses != 0) {
      set(Kind::ma_pulse, base + 4 + 2 * static_cast<float>(view_.ma_pulses) + 2 * off);
    }
    if (off > 0) {
      const auto shortest = static_cast<float>(view_.slo_pulses);
      set(Kind::smeared, base + 3 + 4 * off + 6 * shortest);
    }
  }

  // All bits are there and something about them is wrong.
  void price_wrong(FrameError error, float base, float after) {
    const auto payload = static_cast<float>(usual_.payload_bits);
    const auto pulses = static_cast<float>(view_.ma_pulses);
    const float off = view_.off_grid;
    // A pulse on MA needs no work of SLO.
    const float edges = flip_edge_price * off + 10 * pulses + after;
    const float ack = ack_price(view_.ack_clocks());
    // By the whole payload as the last one that was refused.
    const float refused = std::min(payload + 1, frame_change(refused_.view(), usual_.payload_bits));
    if (error == FrameError::stop_bit) {
      // Another channel follows.
      set(Kind::stop_high, base - after + 1);
      if (view_.frame()[1 + usual_.payload_bits]) set(Kind::stop_repeats, base + 1 + edges);
      set(Kind::flip, base + bits_of(payload) + edges);
      remember();
    } else if (error == FrameError::cds) {
      set(Kind::cds_high, base + 1);
      set(Kind::flip, base + bits_of(payload) + edges);
      remember();
    } else {
      constexpr float near = 12;
      view_.likely = data_price(view_.frame()) < near;
      set(Kind::flip, ack + payload + 2 + edges);
      if (thorough_) {
        set(Kind::flip, flip_price() + edges);
        set(Kind::slip, slip_price() + edges);
      }
      if (view_.gave_up && view_.ma_pulses == 0) {
        set(Kind::restart, ack + payload / 2 + 4);
      }
      if (view_.ma_pulses != 0) {
        set(Kind::ma_pulse, ack + payload + 6 + 2 * (pulses + off) + after);
      }
      price_tails();
      if (usual_.checksum) {
        price_checksum(ack + data_price(view_.frame(), has_strong_checksum()) + after + 2);
      } else if (usual_.no_checksum_fits) {
        const auto free = static_cast<float>(codec_->format().channel_list[0].crc.width_bits);
        set(Kind::other_checksum, base + free + 4 + edge_price * view_.off_grid);
        remember();
      }
    }
    set(Kind::refused, ack + after + refused + 1 + edge_price * off);
    refused_ = {};
    refused_.append(view_.frame());
  }

  // MA stopped before the last bit.
  void price_cut(const CycleEdges& edges) {
    const std::size_t begin = view_.start + 2;
    const std::size_t size = view_.clocks();
    const float off = edge_price * view_.off_grid;
    const std::size_t bits = size > begin ? size - begin : 0;
    const float data = frame_change(before_.view(), bits);
    const float price = 2 + ack_price(view_.ack_clocks()) / 2 + data + off;
    const bool late = longest_ack_ != 0 && view_.ack_clocks() > longest_ack_;
    set(Kind::cut_late, late ? price : price + (longest_ack_ == 0 ? 0.01F : 8.0F));
    set(Kind::cut_in_data, late ? price + 3 : price);
    if (codec_) {
      // A shorter frame has its STOP, and mostly a usual checksum.
      const float whole = tail_of(view_.frame(), true) != 0 ? 12.0F
                          : bits_before_checksum()          ? -1.0F
                                                            : 3.0F;
      set(Kind::refused, ack_price(view_.ack_clocks()) + data + 1 + off + whole);
    }
    if (is_part(edges)) set(Kind::restart, price - 1);
    if (is_held(edges)) set(Kind::ma_held, price - 3);
  }

  // SLO does not change any more from a bit on.
  void price_tails() {
    const float where = count_price(view_.clocks());
    const float off = edge_price * view_.off_grid;
    const auto before = [&](std::size_t tail) {
      const std::size_t begin = view_.start + 2;
      const std::size_t end = view_.clocks() - tail;
      return end <= begin ? 0.0F : frame_change(before_.view(), end - begin);
    };
    const std::size_t ones = tail_of(view_.bits.view(), true);
    if (ones >= least_ones) {
      set(Kind::ones, where + 3 + before(ones) + off);
    }
    const std::size_t zeros = tail_of(view_.bits.view(), false);
    if (zeros >= least_zeros) set(Kind::zeros, where + 4 + before(zeros) + off);
  }

  // The answer is not at its usual place: late, or with the falling edges of MA.
  void price_moved(const CycleEdges& edges) {
    const auto fall =
        std::find_if(edges.slo.begin(), edges.slo.end(),
                     [](const LevelChange& change) { return change.level == Level::low; });
    if (fall == edges.slo.end() || view_.rises.size() < 3 || view_.period.count == 0) return;
    const Picoseconds delay = fall->time - view_.rises[1];
    const double periods =
        static_cast<double>((delay - usual_.delay).count) / static_cast<double>(view_.period.count);
    if (std::abs(periods) < 0.15) return;
    const View as_usual = view_;
    look(edges, delay);
    const bool answered = view_.ack == 1 && view_.start < view_.clocks();
    const float off = edge_price * view_.off_grid;
    if (answered) {
      const float base = ack_price(view_.ack_clocks()) + data_price(view_.frame()) + off;
      const BitView bits = view_.bits.view();
      const std::size_t stop = view_.start + 2 + usual_.payload_bits;
      const bool good = codec_ ? judge(bits).ok()
                               : view_.clocks() > stop && bits.find(true, stop) == view_.clocks();
      const double whole = std::abs(periods - std::round(periods));
      const bool half = std::abs(std::abs(periods) - 0.5) < 0.15;
      const bool repeats = !good && codec_ && view_.clocks() > stop && bits[stop] &&
                           bits[stop - 1] && judge(bits).error().cause == FrameError::stop_bit;
      if (half && repeats) {
        set(Kind::half_early, base + 3);
      } else if (good) {
        if (whole < 0.2) set(Kind::delay_clocks, base + 7);
        if (periods > -0.9 && whole >= 0.1) set(Kind::delay_part, base + 7);
        if (half) set(Kind::half_early, base + 2);
      } else if (periods > 0.8 && whole < 0.2) {
        // Late by clocks: the last bits are missing.
        set(Kind::delay_clocks, base + 9);
      }
    } else if (periods > 0.8) {
      set(Kind::delay_clocks, 12 + off);
    }
    view_ = as_usual;
  }

  // SLO is low at the request: it is stuck, still busy, or inverted.
  void price_low(const CycleEdges& edges) {
    const auto rises = static_cast<std::size_t>(
        std::count_if(edges.slo.begin(), edges.slo.end(),
                      [](const LevelChange& change) { return change.level == Level::high; }));
    const auto rest = rest_before(edges.cycle);
    const bool hurried = !rest || !shortest_rest_ || 100 * *rest < 97 * *shortest_rest_;
    const auto more = static_cast<float>(edges.slo.size());
    const bool soon = hurried && shortest_rest_;
    if (edges.slo.empty()) {
      set(Kind::stuck, soon ? 7 : 1);
      if (soon) set(Kind::hurried, 2);
    } else {
      if (edges.slo.size() == 1) set(Kind::busy, soon ? 10 : 4);
      if (hurried) set(Kind::hurried, (soon ? 1.0F : 4.0F) + 2 * (more - 1));
      // The rest of a request that MA has left before.
      if (soon && was_part_) set(Kind::restart, 1 + 2 * (more - 1));
    }
    // ACK is high, and SLO goes back to the level at which it rests.
    const std::size_t ack = view_.bits.view().find(true, 0);
    const bool back = !edges.slo.empty() && edges.slo.back().level == Level::low;
    if (ack == 1 && rises != 0 && back && view_.slo_pulses == 0) {
      set(Kind::inverted, 2 + 2 * (more - static_cast<float>(rises) - 1));
    }
  }

  // A whole frame of another length: STOP is 0, whatever came before it.
  void price_length() {
    const std::size_t start = view_.start;
    const std::size_t size = view_.clocks();
    if (size < start + least_length || tail_of(view_.frame(), false) == 0 || view_.off_grid != 0)
      return;
    if (size == start + 3 + usual_.payload_bits) return;
    const bool again = other_.size_bits() == size - start;
    const std::size_t bits = bits_before_checksum().value_or(size - start - 3);
    const float data = again ? frame_change(other_.view(), bits) : static_cast<float>(bits);
    const bool late = longest_ack_ != 0 && view_.ack_clocks() > longest_ack_;
    set(Kind::other_length,
        ack_price(view_.ack_clocks()) + data + (again ? 0.3F : 10.0F) + (late ? 4.0F : 0.0F));
    other_ = {};
    other_.append(view_.frame());
  }

  // How many bits come before a usual checksum, which is followed by STOP; clocks after STOP read zeros.
  std::optional<std::size_t> bits_before_checksum() const {
    if (view_.clocks() < view_.start + least_length) return std::nullopt;
    const std::size_t most = view_.clocks() - view_.start - 3;
    constexpr std::size_t most_after = 8;
    const std::size_t zeros = std::min(tail_of(view_.bits.view(), false), most_after);
    constexpr std::array<std::uint8_t, 4> widths{6, 16, 5, 8};
    for (std::size_t after = 0; after < std::min(zeros, most); ++after) {
      for (const std::uint8_t width : widths) {
        const std::size_t all = most - after;
        if (all < width + 4U || all > width + std::size_t{62}) continue;
        const auto [data, data_bits] = number_of(view_.frame().from(2), all - width);
        const std::uint64_t seen = view_.frame().word(2 + all - width, width);
        const CrcBitwise crc({.polynomial = default_polynomial(width), .width_bits = width});
        if (data != 0 && all != usual_.payload_bits && crc(data, data_bits) == seen) {
          return all - width;
        }
      }
    }
    return std::nullopt;
  }

  // The checksum is right by the rule of the maker.
  void price_checksum(float price) {
    if (!usual_.checksum->fits(view_.frame(), before_.view())) return;
    set(Kind::other_checksum, price + edge_price * view_.off_grid);
    remember();
  }

  // The position of this frame is a likely one.
  void remember() {
    data_time_ = view_.time;
    for (std::size_t k = 0; k < channels_.size(); ++k) {
      data_[k] = position_of(view_.frame(), channels_[k]);
    }
  }

  // Before or after it, MA rests for a much shorter time than before good frames.
  bool is_part(const CycleEdges& edges) const {
    if (!shortest_rest_) return false;
    const Picoseconds next =
        decode::elapsed(decode::shifted(edges.cycle.time, edges.cycle.clocked), edges.limit);
    const auto rest = rest_before(edges.cycle);
    return (!edges.last_of_capture && 2 * next < *shortest_rest_) ||
           (rest && 2 * *rest < *shortest_rest_);
  }

  // MA stays low after it, or the requests before or after it are missing.
  bool is_held(const CycleEdges& edges) const {
    if (edges.cycle.cdm == true) return true;
    // This needs requests at a constant rate. A master that waits for START sends all its clocks.
    constexpr std::uint32_t least_regular = 8;
    if (regular_ < least_regular || 4 * regular_ < 3 * intervals_) return false;
    if (view_.clocks() >= fewest_clocks_ || view_.ack_clocks() > longest_ack_) return false;
    const Picoseconds long_time = 8 * interval_ / 5;
    return (!edges.last_of_capture && decode::elapsed(edges.cycle.time, edges.limit) > long_time) ||
           (last_request_ && decode::elapsed(*last_request_, edges.cycle.time) > long_time);
  }

  // START, CDS and STOP: a frame without a channel. If ACK is one clock, or other frames are whole, a
  // master that compensates the line delay also sends the clocks of the delay.
  bool is_brief() const {
    const std::size_t start = view_.start;
    const std::int64_t period = std::max<std::int64_t>(view_.period.count, 1);
    const std::size_t size = view_.clocks();
    if (view_.ack != 1 || size < start + 3) return false;
    if (size == start + 3) return !view_.bits.view()[size - 1];
    const auto late =
        static_cast<std::size_t>(std::max<std::int64_t>(usual_.delay.count, 0) / period);
    const std::size_t more = start == 2 ? late + 1 : fewest_clocks_ != UINT32_MAX ? late : 0;
    return size <= start + 3 + more && view_.bits.view().find(true, start + 2) >= size;
  }

  // A weak one fits after a change at one of the places by chance, and the position then looks likely.
  bool has_strong_checksum() const { return codec_->format().channel_list[0].crc.width_bits >= 6; }

  // The price of the corrected frame.
  float mended_price(BitView bits) const {
    if (!judge(bits).ok()) return impossible;
    return ack_price(view_.ack_clocks()) +
           data_price(bits.from(view_.start), has_strong_checksum());
  }

  // One bit is wrong.
  float flip_price() const {
    float best = impossible;
    Bits bits = view_.bits;
    for (std::size_t i = 0; i < usual_.payload_bits; ++i) {
      bits.flip(view_.start + 2 + i);
      best = std::min(best, count_price(usual_.payload_bits) + mended_price(bits.view()));
      bits.flip(view_.start + 2 + i);
    }
    return best;
  }

  // The encoder has taken a clock twice, or missed one: the frame with the clock corrected, and STOP.
  float slip_price() const {
    const BitView bits = view_.bits.view();
    const std::size_t begin = view_.start + 2;
    const std::size_t end = begin + usual_.payload_bits;
    float best = impossible;
    for (std::size_t at = begin; at < end; ++at) {
      // A clock too many: the bit that was not seen is either.
      for (const bool level : {false, true}) {
        Bits longer;
        longer.append(bits.first(at));
        longer.append(level);
        longer.append(bits.from(at));
        best = std::min(best, 1 + mended_price(longer.view()));
      }
      Bits shorter;
      shorter.append(bits.first(at));
      shorter.append(bits.from(at + 1));
      best = std::min(best, mended_price(shorter.view()));
    }
    // After a clock too many, STOP is in place of the last bit; after one too few, the last bit is in
    // place of STOP.
    const bool fits = !bits[end - 1] || (end < bits.size_bits() && bits[end]);
    return best + count_price(2 * std::size_t{usual_.payload_bits}) + (fits ? 2.0F : 8.0F);
  }

  float ack_price(std::size_t clocks) const {
    const double seen = acks_[std::min(clocks, acks_.size() - 1)];
    return -static_cast<float>(std::log2((seen + 0.15) / (frames_ + 4.0)));
  }

  // moves_on: or the position moves on as between the last two good frames
  // The position fields of a frame, whatever its checksum is.
  float data_price(BitView frame, bool moves_on = false) const {
    float price = 0;
    for (std::size_t k = 0; k < channels_.size(); ++k) {
      const unsigned size = std::max(1U, channels_[k].format.position_bits());
      const std::uint64_t position = position_of(frame, channels_[k]);
      const float same = change_price(data_[k], position, size);
      price += moves_on ? std::min(same, change_price(due_position(k), position, size)) : same;
    }
    return price;
  }

  // The position of an axis that moves on as between the last two good frames.
  std::uint64_t due_position(std::size_t k) const {
    const unsigned unused = 64 - std::max(1U, channels_[k].format.position_bits());
    const auto step = static_cast<std::int64_t>(steps_[k] << unused) >> unused;
    const auto from_then = static_cast<double>(decode::elapsed(data_time_, view_.time).count);
    const auto in_step = static_cast<double>(std::max<std::int64_t>(step_time_.count, 1));
    const double way = static_cast<double>(step) * std::min(from_then / in_step, 100.0);
    return data_[k] + static_cast<std::uint64_t>(std::llround(std::clamp(way, -9e18, 9e18)));
  }

  // Bits that are missing at the end are 0.
  static std::uint64_t position_of(BitView frame, const Place& place) {
    const unsigned bits = place.format.data_bits;
    const BitView data = frame.from(place.at).first(bits);
    if (data.empty()) return 0;
    const auto seen = static_cast<unsigned>(data.size_bits());
    return frame_detail::position_of(place.format, data.word(0, seen) << (bits - seen));
  }

  // The first bits after CDS, by their change from another frame.
  float frame_change(BitView before, std::size_t size) const {
    const auto [value, bits] = number_of(view_.frame().from(2), size);
    const auto [last, last_bits] = number_of(before.from(2), size);
    if (bits == 0) return 0;
    const auto rest = static_cast<float>(size - bits);
    if (last_bits != bits) return rest + static_cast<float>(bits);
    return rest + change_price(last, value, bits);
  }

  Result<Frame, FrameFault> judge(BitView bits) const {
    return decode_payload(bits, FrameStart{view_.start, 1, 1}, *codec_);
  }

  std::optional<FrameCodec<>> codec_;
  bool thorough_ = true;
  Picoseconds resolution_;
  Usual usual_;
  std::vector<Place> channels_;
  View view_;
  // For the request that was read last.
  Prices prices_{};
  // From the good frames before.
  std::array<std::uint32_t, 512> acks_{};
  std::uint32_t frames_ = 0;
  std::uint16_t longest_ack_ = 0;
  std::uint32_t fewest_clocks_ = UINT32_MAX;
  std::array<std::uint64_t, max_channels> data_{};
  std::array<std::uint64_t, max_channels> steps_{};
  Picoseconds data_time_{};
  Picoseconds step_time_{};
  std::optional<Picoseconds> shortest_rest_;
  // The last frame of any kind, the last one that was refused, and the last one whose length was
  // unusual, all from START on.
  decode::RawBits before_;
  decode::RawBits refused_;
  decode::RawBits other_;
  // The last unusual request from LAT on.
  Bits last_;
  std::optional<Picoseconds> last_edge_;
  std::optional<Picoseconds> last_request_;
  bool was_good_ = false;
  // From a good frame to the next one: the shortest, how many there were, and how many like it.
  Picoseconds interval_{};
  std::uint32_t intervals_ = 0;
  std::uint32_t regular_ = 0;
  // The last request may be a part of one.
  bool was_part_ = false;
};

}  // namespace biss::explain
