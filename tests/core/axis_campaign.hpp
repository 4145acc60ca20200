// A campaign of faults on an axis: an axis of a machine moves, its encoder answers on a line with
// faults, and a DMA fails in every way. Each position is compared with the movement, each cycle
// with its faults. The frames are made here, bit by bit, without the code under test.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>

#include "biss/axis/encoder_axis.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/fixed.hpp"
#include "tests/core/random.hpp"

namespace biss::test {

inline constexpr CatalogueEntry campaign_encoder = catalogue_encoder("resolute-26");
inline constexpr SpiSetup campaign_spi{.period = nanoseconds(100),
                                       .line_delay = {.max = nanoseconds(700)}};
inline constexpr SpiReader campaign_reader{FixedCodec<campaign_encoder.frame_format()>{},
                                           campaign_spi, campaign_encoder.timing};

/// What happens to one cycle.
enum class AxisFault : std::uint8_t {
  none,
  warning,      ///< nW is 0
  error_bit,    ///< nE is 0
  flips,        ///< one or two bits of data and CRC
  pulled,       ///< SLO is high from a bit of the data on
  unplugged,    ///< SLO is high throughout
  stuck_low,    ///< SLO is low throughout
  no_start,     ///< SLO stays low after ACK began
  early_start,  ///< ACK is shorter than the encoder's
  late_ack,     ///< a line delay that is too long
  dead_dma,     ///< the end of the transfer is reported, nothing was written
  cache_kept,   ///< a line of the cache is the one before the transfer
  cut_dma,      ///< the last bytes are not written
  failed,       ///< the DMA reports an error
  lost_end,     ///< the end of the transfer is not reported
  doubled_end,  ///< it is reported twice
  late_end,     ///< it comes after the next request
  order,        ///< the end is reported again while the next transfer runs
  jump,         ///< a good frame with a position half a turn away
};
inline constexpr std::uint32_t axis_fault_count = 19;

/// A movement back and forth over some turns, in counts, at a known largest speed.
struct Movement {
  std::int64_t half_period_ps = 1;
  std::int64_t height = 0;
  std::int64_t start = 0;

  constexpr std::int64_t at(std::int64_t time_ps) const {
    const std::int64_t within = time_ps % (2 * half_period_ps);
    const std::int64_t rising = within < half_period_ps ? within : 2 * half_period_ps - within;
    return start + rising * height / half_period_ps;
  }
};

/// An SPI whose transfer ends when the test says so.
struct HeldSpi {
  std::span<std::uint8_t> receive{};
  bool busy = false;

  constexpr bool start(std::span<std::uint8_t> into) {
    if (busy) return false;
    busy = true;
    receive = into;
    return true;
  }
};

class AxisCampaign {
 public:
  static constexpr std::int64_t cycle_ps = 62'500'000;
  static constexpr std::int64_t turn = std::int64_t{1} << 26U;

  constexpr explicit AxisCampaign(std::uint64_t seed) : random_(seed) {
    // The clock of every other axis wraps around.
    if (random_.flip()) {
      zero_ps_ =
          static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()) - random_.bits(36);
    }
  }
  AxisCampaign(const AxisCampaign&) = delete;

  /// \return false: a position or a cause is wrong, see problem()
  constexpr bool run(std::uint32_t cycles) {
    for (std::uint32_t i = 0; i < cycles && problem_ == nullptr; ++i) step();
    return problem_ == nullptr;
  }
  constexpr const char* problem() const { return problem_; }
  constexpr AxisFault last_fault() const { return fault_; }

  /// How often each cause came; of all cycles.
  std::array<std::uint32_t, axis_cause_count> seen{};
  std::array<std::uint32_t, axis_state_names.size()> states{};

 private:
  using Reader = std::remove_cvref_t<decltype(campaign_reader)>;
  static constexpr std::size_t bytes = campaign_reader.bytes();

  using Spi = HeldSpi;
  static constexpr Movement movement(Random& random) {
    return {.half_period_ps = cycle_ps * (400 + random.below(300)),
            .height = 100'000'000 + random.below(100'000'000),
            .start = random.below(turn)};
  }
  static constexpr AxisSetup setup(Random& random, const Movement& movement) {
    const std::int64_t a_cycle = movement.height / (movement.half_period_ps / cycle_ps) + 1;
    const std::uint32_t trip_after = random.below(4) == 0 ? 100 : 3 + random.below(6);
    return {.cycle = Picoseconds{cycle_ps},
            .to_sampling = sampling_delay(campaign_spi, campaign_encoder.timing),
            .max_step = a_cycle + a_cycle / 8 + 2,
            .bad_cycles = random.flip() ? BadCycleRule::extrapolate : BadCycleRule::hold,
            .trip_after = static_cast<std::uint16_t>(trip_after),
            .power_up = Picoseconds{cycle_ps * random.below(50)},
            .reversed = random.flip(),
            .offset = static_cast<std::int64_t>(random.bits(40))};
  }

  using Causes = std::uint32_t;
  static constexpr Causes of(AxisCause cause) { return 1U << static_cast<unsigned>(cause); }

  constexpr void wrong(const char* what) {
    if (problem_ == nullptr) problem_ = what;
  }

  constexpr Picoseconds now(std::int64_t time_ps) const {
    return Picoseconds{static_cast<std::int64_t>(zero_ps_ + static_cast<std::uint64_t>(time_ps))};
  }

  // ---- The encoder's frame and the line

  constexpr void put(std::span<std::uint8_t> into, std::size_t& at, std::uint64_t value,
                     unsigned bits) const {
    while (bits-- != 0) {
      const std::size_t byte = at / 8;
      const auto mask = static_cast<std::uint8_t>(0x80U >> (at++ % 8));
      if (byte >= into.size()) return;
      into[byte] = static_cast<std::uint8_t>((value >> bits & 1U) != 0 ? into[byte] | mask
                                                                       : into[byte] & ~mask);
    }
  }

  static constexpr std::uint64_t with_crc(std::uint64_t data, unsigned bits) {
    std::uint64_t rest = data << 6U;
    for (unsigned bit = bits; bit-- != 0;) {
      if ((rest >> (bit + 6U) & 1U) != 0) rest ^= std::uint64_t{0x43} << bit;
    }
    return data << 6U | (~rest & 0x3FU);
  }

  // What SLO shows in each clock. The encoder keeps it low after STOP.
  constexpr std::array<std::uint8_t, bytes> answer(std::int64_t sampled_ps) {
    std::array<std::uint8_t, bytes> line{};
    if (fault_ == AxisFault::unplugged) line.fill(0xFF);
    if (fault_ == AxisFault::unplugged || fault_ == AxisFault::stuck_low) return line;
    std::uint64_t position = static_cast<std::uint64_t>(movement_.at(sampled_ps)) & (turn - 1);
    if (fault_ == AxisFault::jump) position ^= turn / 2;
    std::uint64_t flags = 3;
    if (fault_ == AxisFault::error_bit) flags = random_.flip() ? 1 : 0;
    if (fault_ == AxisFault::warning) flags = 2;
    std::uint64_t word = with_crc(position << 2U | flags, 28);
    if (fault_ == AxisFault::flips) {
      const std::uint64_t first = random_.below(34);
      word ^= std::uint64_t{1} << first;
      const std::uint64_t second = random_.below(34);
      if (second != first) word ^= std::uint64_t{1} << second;
    }
    const FrameBounds& bounds = campaign_reader.bounds();
    unsigned lead = bounds.lead_min_clocks +
                    random_.below(bounds.lead_max_clocks - bounds.lead_min_clocks + 1U);
    unsigned ack = bounds.ack_min_clocks + random_.below(40);
    if (fault_ == AxisFault::late_ack) lead = bounds.lead_max_clocks + 1U + random_.below(8);
    if (fault_ == AxisFault::early_start) ack = 1 + random_.below(bounds.ack_min_clocks - 1U);
    std::size_t at = 0;
    for (unsigned i = 0; i < lead; ++i) put(line, at, 1, 1);
    if (fault_ == AxisFault::no_start) return line;
    at += ack;
    put(line, at, 2, 2);
    put(line, at, word, 34);
    if (fault_ == AxisFault::pulled) {
      at -= 1 + random_.below(34);
      while (at < bytes * 8) put(line, at, 1, 1);
    }
    return line;
  }

  // ---- One cycle

  constexpr AxisFault next_fault() {
    if (outage_ != 0 && fault_ != AxisFault::jump) {
      --outage_;
      return fault_;
    }
    if (random_.below(often_) != 0) return AxisFault::none;
    // A replugged or switched encoder.
    if (random_.below(often_) == 0) outage_ = random_.below(30);
    const auto fault = static_cast<AxisFault>(random_.below(axis_fault_count));
    // Without a position, or long after the last one, nothing shows that it jumps.
    const bool shows =
        axis_.axis().state() != AxisState::no_position && time_ps_ - measured_ps_ < 20 * cycle_ps;
    return fault != AxisFault::jump || shows ? fault : AxisFault::none;
  }

  constexpr void step() {
    // A control interrupt that was delayed is followed by the next one at once.
    const bool early = random_.below(often_ * 8) == 0;
    time_ps_ += (early ? 0 : cycle_ps) + random_.below(cycle_ps / 8);
    // The control interrupt is lost for some cycles, seldom for so many that turns are lost.
    if (random_.below(often_ * 8) == 0) {
      time_ps_ += cycle_ps * random_.below(random_.below(8) == 0 ? 200 : 6);
    }
    if (axis_.axis().state() == AxisState::tripped && random_.below(8) == 0) reset();
    const bool late = spi_.busy;
    const std::int64_t asked_ps = asked_ps_;
    request(late);
    if (late) {
      // The transfer before ends now, with the position of its own request.
      complete(answer_, AxisFault::late_end, asked_ps, allowed_good());
      return;
    }
    if (again_) {  // the end before is reported again, while this transfer has written some bytes
      again_ = false;
      const std::size_t written = random_.below(bytes + 1U);
      const auto line = answer(asked_ps_ + setup_.to_sampling.count);
      std::copy_n(line.begin(), written, spi_.receive.begin());
      spi_.busy = false;
      expect([this] { axis_.transfer_complete(); }, frame_causes | allowed_good());
      check(asked_ps_);
      expect([this] { axis_.transfer_complete(); }, of(AxisCause::unexpected));
      return;
    }
    transfer();
  }

  constexpr void request(bool late) {
    const bool unanswered = axis_.waits();
    Causes allowed = late ? of(AxisCause::late) : unanswered ? of(AxisCause::unanswered) : 0;
    if (!late) asked_ps_ = time_ps_;
    expect([this] { axis_.request(now(time_ps_)); }, allowed);
    check(late ? time_ps_ : unanswered ? before_ps_ : asked_ps_, allowed != 0);
    if (!late) before_ps_ = asked_ps_;
  }

  constexpr void transfer() {
    fault_ = next_fault();
    const auto line = answer(asked_ps_ + setup_.to_sampling.count);
    switch (fault_) {
      case AxisFault::late_end:
        answer_ = line;
        return;  // the SPI is busy at the next request
      case AxisFault::lost_end:
        std::copy_n(line.begin(), random_.below(bytes + 1U), spi_.receive.begin());
        spi_.busy = false;
        return;
      case AxisFault::failed:
        spi_.busy = false;
        expect([this] { axis_.transfer_failed(); }, of(AxisCause::failed));
        return check(asked_ps_);
      case AxisFault::dead_dma:
        spi_.busy = false;
        expect([this] { axis_.transfer_complete(); }, of(AxisCause::no_response));
        return check(asked_ps_);
      default:
        return complete(line, fault_, asked_ps_, causes_of(fault_));
    }
  }

  constexpr void complete(const std::array<std::uint8_t, bytes>& line, AxisFault fault,
                          std::int64_t asked_ps, Causes allowed) {
    constexpr std::size_t cache_line = 32;
    const std::size_t from = fault == AxisFault::cache_kept ? cache_line : 0;
    const std::size_t to = fault == AxisFault::cut_dma ? random_.below(bytes) : bytes;
    for (std::size_t i = from; i < to; ++i) spi_.receive[i] = line[i];
    spi_.busy = false;
    expect([this] { axis_.transfer_complete(); }, allowed);
    check(asked_ps);
    if (fault == AxisFault::doubled_end) {
      expect([this] { axis_.transfer_complete(); }, of(AxisCause::unexpected));
    }
    again_ = fault == AxisFault::order;
  }

  constexpr void reset() {
    const Causes allowed = axis_.waits() ? of(AxisCause::unanswered) : 0;
    expect([this] { axis_.reset(); }, allowed);
    if (axis_.position().state != AxisState::no_position) wrong("no reset");
    base_.reset();
    again_ = false;
    spi_.busy = false;
    outage_ = 0;
  }

  // ---- The judge

  static constexpr Causes frame_causes = 0x3FE;  // those of FrameError

  constexpr Causes causes_of(AxisFault fault) const {
    switch (fault) {
      case AxisFault::none:
      case AxisFault::doubled_end:
      case AxisFault::order:
        return allowed_good();
      case AxisFault::warning:
        return allowed_good() | of(AxisCause::warning);
      case AxisFault::error_bit:
        return of(AxisCause::error_bit);
      case AxisFault::jump: {
        const bool tripped = axis_.axis().state() == AxisState::tripped;
        return tripped ? of(AxisCause::tripped)
                       : of(AxisCause::step) | (allowed_good() & of(AxisCause::turns));
      }
      case AxisFault::flips:
        return of(AxisCause::crc);
      case AxisFault::pulled:
        return of(AxisCause::crc) | of(AxisCause::stop_bit);
      case AxisFault::unplugged:
      case AxisFault::dead_dma:
      case AxisFault::cache_kept:
        return of(AxisCause::no_response);
      case AxisFault::stuck_low:
        return of(AxisCause::not_ready);
      case AxisFault::no_start:
        return of(AxisCause::no_start);
      case AxisFault::early_start:
        return of(AxisCause::ack_range);
      case AxisFault::late_ack:
        return of(AxisCause::response_range);
      case AxisFault::cut_dma:
        return frame_causes | allowed_good();
      default:
        return 0;
    }
  }

  // The causes of a good frame in this state.
  constexpr Causes allowed_good() const {
    const AxisState state = axis_.axis().state();
    if (state == AxisState::tripped) return of(AxisCause::tripped);
    if (state == AxisState::no_position) {
      return of(AxisCause::first) | of(AxisCause::ok) | of(AxisCause::early) | of(AxisCause::turns);
    }
    const std::int64_t cycles = (time_ps_ - measured_ps_) / cycle_ps + 1;
    const bool unknown_turns = setup_.max_step * cycles >= turn / 2;
    const bool early = asked_ps_ - measured_ps_ < cycle_ps / 8;
    return of(early ? AxisCause::early : AxisCause::ok) |
           (unknown_turns ? of(AxisCause::turns) : 0);
  }

  // Calls a function; exactly one cause is counted, one of those that are allowed, or none.
  template <class Call>
  constexpr void expect(const Call& call, Causes allowed) {
    const auto before = axis_.axis().counts();
    call();
    Causes counted = 0;
    for (std::size_t i = 0; i < axis_cause_count; ++i) {
      const auto cause = static_cast<AxisCause>(i);
      const std::uint32_t more = axis_.axis().counts()[cause] - before[cause];
      if (more > 1) wrong("a cause was counted twice");
      if (more == 0) continue;
      if (counted != 0) wrong("two causes for one cycle");
      counted = of(cause);
      ++seen[i];
    }
    if (allowed == 0 ? counted != 0 : (counted & allowed) == 0) wrong("not the cause of the fault");
  }

  // The position is where it says, at its moment and, if it is held, at the last sampling.
  constexpr void check(std::int64_t asked_ps, bool ended = true) {
    if (!ended) return;
    const AxisPosition out = axis_.position();
    ++states[static_cast<std::size_t>(out.state)];
    if (!out.usable()) return;
    const bool measured = out.state == AxisState::measured;
    const std::int64_t moment_ps =
        static_cast<std::int64_t>(static_cast<std::uint64_t>(out.moment.count) - zero_ps_);
    const std::int64_t position =
        setup_.reversed ? setup_.offset - out.position : out.position - setup_.offset;
    if (measured) {
      measured_ps_ = asked_ps;
      if (moment_ps != asked_ps + setup_.to_sampling.count) wrong("not the moment of the sampling");
      if (out.uncertainty != 0) wrong("a measured position is not certain");
    }
    if (!base_) base_ = position - movement_.at(moment_ps);
    if (*base_ % turn != 0) wrong("the first position is wrong");
    const auto error_at = [&](std::int64_t time_ps) {
      const std::int64_t error = position - *base_ - movement_.at(time_ps);
      return error < 0 ? -error : error;
    };
    if (error_at(moment_ps) > out.uncertainty) wrong("a position outside of its uncertainty");
    const bool held = out.state == AxisState::held;
    if (held && error_at(asked_ps + setup_.to_sampling.count) > out.uncertainty) {
      wrong("a held position outside of its uncertainty");
    }
  }

  Random random_;
  Movement movement_ = movement(random_);
  AxisSetup setup_ = setup(random_, movement_);
  Spi spi_{};
  EncoderAxis<Spi, Reader, bytes> axis_{spi_, campaign_reader, setup_};
  std::uint32_t often_ = 2 + random_.below(60);
  std::uint64_t zero_ps_ = 0;
  std::int64_t time_ps_ = 0;
  std::int64_t asked_ps_ = 0;
  std::int64_t before_ps_ = 0;
  std::int64_t measured_ps_ = 0;
  std::array<std::uint8_t, bytes> answer_{};  // of a transfer that ends late
  AxisFault fault_ = AxisFault::none;
  std::uint32_t outage_ = 0;
  bool again_ = false;
  std::optional<std::int64_t> base_{};
  const char* problem_ = nullptr;
};

}  // namespace biss::test
