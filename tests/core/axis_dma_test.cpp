// An axis over a DMA stream and a data cache, as on an STM32F7 or H7: the steps of a driver (clean,
// start, end, invalidate) with faults of the registers and of the cache. The bytes of the axis are
// what the processor sees, `memory_` is what the DMA writes.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "tests/core/axis_campaign.hpp"
#include "tests/core/mistakes.hpp"
#include "tests/core/test.hpp"

namespace biss::axis_dma_test {

enum class Fault : std::uint8_t {
  none,
  transfer_error,  // TEIF, and the stream stops
  fifo_error,      // a byte is lost, NDTR never reaches 0, and EN stays
  half_transfer,   // HTIF is taken for the end
  flags_kept,      // TCIF is still set at the start
  no_request,      // the peripheral requests no byte, and the driver reports the end
  not_cleaned,     // the lines of ones are dirty
  not_invalid,     // the lines are not invalidated
  fetched_early,   // the lines are not invalidated, and were read while the DMA wrote
  shared_line,     // another variable in a line is written while the DMA writes
};
constexpr std::uint32_t fault_count = 10;

enum class Line : std::uint8_t { invalid, clean, dirty };

// The driver, with the stream and the cache below it. A line of the cache has 32 bytes.
class Board {
 public:
  std::size_t ndtr = 0;
  bool enabled = false;  // EN
  bool error = false;    // TEIF
  Fault fault = Fault::none;
  std::size_t offset = 0;  // of the buffers from a line

  // Called by the axis; the bytes are ones, which are in dirty lines.
  bool start(std::span<std::uint8_t> receive) {
    if (enabled) return false;
    seen_ = receive;
    other_ = 1 - other_;
    lines_.fill(Line::dirty);
    if (fault != Fault::not_cleaned) {
      for (std::size_t k = 0; k < lines_.size(); ++k) clean(k);
    }
    ndtr = receive.size();
    enabled = true;
    error = false;
    return true;
  }

  // The stream writes the next bytes of the line.
  void write(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) {
      if (!enabled || ndtr == 0) return;
      memory()[seen_.size() - ndtr--] = byte;
    }
    if (ndtr == 0) enabled = false;
  }
  void evict(std::size_t k) {
    clean(k);
    lines_[k] = Line::invalid;
  }
  void fetch(std::size_t k) {
    if (lines_[k] != Line::invalid) return;
    copy(memory(), seen_, k);
    lines_[k] = Line::clean;
  }
  // The processor writes to another variable of the line.
  void write_other(std::size_t k) {
    fetch(k);
    lines_[k] = Line::dirty;
  }
  // Before the axis reads.
  void invalidate() {
    if (fault != Fault::not_invalid && fault != Fault::fetched_early) lines_.fill(Line::invalid);
    for (std::size_t k = 0; k < lines_.size(); ++k) fetch(k);
  }

 private:
  std::span<std::uint8_t> memory() { return std::span(memory_[other_]).first(seen_.size()); }
  void clean(std::size_t k) {
    if (lines_[k] != Line::dirty) return;
    copy(seen_, memory(), k);
    lines_[k] = Line::clean;
  }
  void copy(std::span<const std::uint8_t> from, std::span<std::uint8_t> to, std::size_t k) const {
    for (std::size_t i = 0; i < to.size(); ++i) {
      if ((i + offset) / 32 == k) to[i] = from[i];
    }
  }

  std::span<std::uint8_t> seen_{};
  std::array<std::array<std::uint8_t, 64>, 2> memory_{};
  std::size_t other_ = 0;
  std::array<Line, 2> lines_{};
};

using Causes = std::uint32_t;
constexpr Causes of(AxisCause cause) { return 1U << static_cast<unsigned>(cause); }

// A machine that moves, with one fault in some cycles.
class Campaign {
 public:
  static constexpr std::int64_t cycle_ps = 62'500'000;
  static constexpr std::int64_t turn = std::int64_t{1} << 26U;

  explicit Campaign(std::uint64_t seed) : random_(seed) {
    board_.offset = random_.flip() ? 0 : 4 * random_.below(8);
  }

  void cycle() {
    board_.fault =
        random_.below(3) == 0 ? static_cast<Fault>(random_.below(fault_count)) : Fault::none;
    // A buffer in one line of its own shares nothing.
    if (board_.offset == 0 && board_.fault == Fault::shared_line) board_.fault = Fault::none;
    if (axis_.axis().state() == AxisState::tripped) {
      expect([this] { axis_.reset(); }, axis_.waits() ? of(AxisCause::unanswered) : 0);
      board_.enabled = false;
      base_.reset();
    }
    time_ps_ += cycle_ps;
    const std::int64_t sampled_ps = time_ps_ + firmware_.axis.to_sampling.count;
    line_.position = static_cast<std::uint32_t>(movement_.at(sampled_ps) & (turn - 1));
    const bool runs = board_.enabled;
    expect([this] { axis_.request(Picoseconds{time_ps_}); }, runs ? of(AxisCause::late)
                                                             : axis_.waits()
                                                                 ? of(AxisCause::unanswered)
                                                                 : 0);
    if (runs) {
      board_.enabled = false;  // the driver stops the stream
      return check();
    }
    std::array<std::uint8_t, 64> bytes{};
    line_.transfer({}, time_ps_, std::span(bytes).first(size_));
    transfer(std::span<const std::uint8_t>(bytes).first(size_));
    check();
  }

  const char* problem = nullptr;
  std::array<std::uint32_t, axis_cause_count> seen{};

 private:
  static constexpr Causes frame_causes = 0x3FE;

  void transfer(std::span<const std::uint8_t> bytes) {
    const std::size_t part = random_.below(static_cast<std::uint32_t>(size_));
    const std::size_t k = random_.below(2);
    switch (board_.fault) {
      case Fault::transfer_error:
        board_.write(bytes.first(part));
        board_.enabled = false;
        board_.error = true;
        break;
      case Fault::fifo_error:
        board_.write(bytes.first(part));
        return board_.write(bytes.subspan(part + 1));
      case Fault::half_transfer:
      case Fault::flags_kept: {
        const bool half = board_.fault == Fault::half_transfer;
        board_.write(bytes.first(half ? size_ / 2 : part));
        end(frame_causes);
        board_.write(bytes.subspan(half ? size_ / 2 : part));
        return end(of(AxisCause::unexpected));
      }
      case Fault::no_request:
        board_.enabled = false;
        return end(of(AxisCause::no_response));
      case Fault::not_cleaned:
      case Fault::fetched_early:
      case Fault::shared_line:
        if (random_.flip()) board_.evict(k);
        board_.write(bytes.first(part));
        if (board_.fault == Fault::fetched_early) board_.fetch(k);
        if (board_.fault == Fault::shared_line) board_.write_other(k);
        if (random_.flip()) board_.evict(k);
        board_.write(bytes.subspan(part));
        if (board_.fault == Fault::shared_line) board_.evict(k);
        return end(frame_causes | good());
      default:
        board_.write(bytes);
    }
    end(board_.fault == Fault::not_invalid ? of(AxisCause::no_response) : good());
  }

  // The interrupt of the
  void end(Causes allowed) {
    if (board_.error) {
      return expect([this] { axis_.transfer_failed(); }, of(AxisCause::failed));
    }
    if (axis_.waits()) board_.invalidate();
    expect([this] { axis_.transfer_complete(); }, allowed);
  }

  Causes good() const {
    if (axis_.axis().state() == AxisState::tripped) return of(AxisCause::tripped);
    return of(AxisCause::ok) | of(AxisCause::first);
  }

  template <class Call>
  void expect(const Call& call, Causes allowed) {
    const auto before = axis_.axis().counts();
    call();
    Causes counted = 0;
    for (std::size_t i = 0; i < axis_cause_count; ++i) {
      const auto cause = static_cast<AxisCause>(i);
      const std::uint32_t more = axis_.axis().counts()[cause] - before[cause];
      if (more > 1 || (more == 1 && counted != 0)) problem = "more than one cause";
      if (more == 1) counted = of(cause);
      seen[i] += more;
    }
    if (allowed == 0 ? counted != 0 : (counted & allowed) == 0) problem = "another cause";
  }

  void check() {
    const AxisPosition now = axis_.position();
    if (!now.usable()) return;
    const std::int64_t error = now.position - movement_.at(now.moment.count);
    if (!base_) base_ = error;
    if (*base_ % turn != 0) problem = "the first position is wrong";
    const std::int64_t apart = error - *base_;
    if ((apart < 0 ? -apart : apart) > now.uncertainty) problem = "outside of the uncertainty";
  }

  test::Random random_;
  test::Movement movement_{
      .half_period_ps = cycle_ps * 500, .height = 100'000'000, .start = 12'345};
  mistakes::Firmware firmware_{};
  mistakes::Line line_{};
  Board board_{};
  mistakes::Bench<>::Reader reader_{FrameCodec<CrcFast, 1>(firmware_.format), firmware_.spi,
                                    mistakes::encoder.timing};
  EncoderAxis<Board, mistakes::Bench<>::Reader, 64> axis_{board_, reader_, firmware_.axis};
  std::size_t size_ = reader_.bytes();
  std::int64_t time_ps_ = 0;
  std::optional<std::int64_t> base_{};
};

BISS_TEST(EncoderAxis, FaultsOfDmaRegistersAndCache_HaveACauseAndNoWrongPosition) {
  BISS_RANDOM(random, 0xCAC4E);
  std::array<std::uint32_t, axis_cause_count> seen{};
  for (unsigned k = 0; k < 20; ++k) {
    Campaign campaign(random.next());
    for (unsigned i = 0; i < 300 && campaign.problem == nullptr; ++i) campaign.cycle();
    BISS_EXPECT(campaign.problem == nullptr) << campaign.problem << ", run " << k;
    for (std::size_t i = 0; i < seen.size(); ++i) seen[i] += campaign.seen[i];
  }
  for (const AxisCause cause :
       {AxisCause::ok, AxisCause::no_response, AxisCause::stop_bit, AxisCause::late,
        AxisCause::unanswered, AxisCause::failed, AxisCause::unexpected}) {
    BISS_EXPECT(seen[index_of(cause)] > 20) << name_of(cause).data();
  }
}

}  // namespace biss::axis_dma_test
