// The master with any SLO: every request ends in bounded time, and its reading is the result of
// decode_frame().
//
// Input: the format's number in frame_formats; the period above 50 ns in steps of 20 ns; bit 0
// compensation, bit 1 CDM, bit 2 late calls, bit 3 a script instead of an edge train, bits 4…5 the
// timeout's rule, bits 6…7 slaves; longest ACK in half periods; extra clocks; bits 0…3 resolution
// and bits 4…7 shift of the sampling point; the longest line delay in half periods; the line delay
// of a script in eighths of a period; then either changes of SLO, two bytes each, the time since
// the last one in sixteenths of a period, or the script: SLO's level at each rising edge of MA from
// the first on.
#include <deque>

#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/master/request.hpp"
#include "fuzz/frame_formats.hpp"
#include "fuzz/target.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;

using Codec = FrameCodec<CrcTable<4>>;
using Master = RequestCycle<Codec>;

constexpr std::size_t header_bytes = 8;
constexpr int requests_a_train = 4;

MasterSetup setup_of(const std::uint8_t* header) {
  const Picoseconds period = nanoseconds(50 + header[1] * 20);
  const std::uint8_t flags = header[2];
  const int shift = header[5] / 16 - 8;
  return {.period = period,
          .timing = {.clock_max = hertz_max,
                     .start_min = period * (header[3] / 32),
                     .ack_max = period * header[3] / 2,
                     .timeout = {static_cast<TimeoutRule>((flags >> 4U) % 3U), microseconds(20)},
                     .cycle_min = period * header[7]},
          .slaves = static_cast<std::uint8_t>(1U + (flags >> 6U)),
          .compensate = (flags & 1U) != 0,
          .cdm = (flags & 2U) != 0,
          .extra_clocks = header[4],
          .sample_step = period * (header[5] % 16) / 32,
          .sample_shift = period * (shift == -8 ? 0 : shift) / 16,
          .line_delay_max = period * header[6] / 2,
          .no_error_flag = true,
          .unchecked = true};
}

// The longest duration of a request without late calls.
Picoseconds longest(const MasterSetup& setup, unsigned payload_bits) {
  const std::int64_t clocks =
      request_ack_bounds(setup).max_clocks + payload_bits + setup.extra_clocks + std::int64_t{12};
  const Picoseconds rest = std::max(biss_static_timeout_max, setup.timing.timeout.time);
  return setup.period * clocks + 2 * setup.line_delay_max + rest;
}

// SLO with the changes of the input.
class Train {
 public:
  Train(std::span<const std::uint8_t> bytes, Picoseconds period) : bytes_(bytes), period_(period) {
    advance();
  }
  Picoseconds next() const { return next_; }
  void tell(bool, Picoseconds) {}
  // The level that the master sees from now on.
  bool level(Picoseconds now) {
    while (next_ <= now) {
      level_ = !level_;
      advance();
    }
    return level_;
  }

 private:
  void advance() {
    if (bytes_.size() < 2) {
      next_ = never;
      return;
    }
    const int sixteenths = bytes_[0] * 256 + bytes_[1];
    last_ += std::max(period_ * sixteenths / 16, picoseconds(1));
    next_ = last_;
    bytes_ = bytes_.subspan(2);
  }

  std::span<const std::uint8_t> bytes_;
  Picoseconds period_;
  Picoseconds last_{};
  Picoseconds next_ = never;
  bool level_ = true;
};

// SLO of a device: one bit of the script at each rising edge, 1 again after the timeout.
class Script {
 public:
  Script(BitView bits, Picoseconds delay, Picoseconds timeout)
      : bits_(bits), delay_(delay), timeout_(timeout) {}
  Picoseconds next() const {
    return std::min(expires_, changes_.empty() ? never : changes_.front().first);
  }
  void tell(bool ma, Picoseconds now) {
    if (expires_ <= now) {
      changes_.emplace_back(now + delay_, true);
      expires_ = never;
    }
    if (ma != ma_) {
      ma_ = ma;
      expires_ = now + timeout_;
      if (ma) changes_.emplace_back(now + delay_, at_ < bits_.size_bits() && bits_[at_++]);
    }
  }
  bool level(Picoseconds now) {
    while (!changes_.empty() && changes_.front().first <= now) {
      level_ = changes_.front().second;
      changes_.pop_front();
    }
    return level_;
  }

 private:
  BitView bits_;
  Picoseconds delay_;
  Picoseconds timeout_;
  std::deque<std::pair<Picoseconds, bool>> changes_;
  std::size_t at_ = 0;
  Picoseconds expires_ = never;
  bool ma_ = true;
  bool level_ = true;
};

// Makes one request. \return its end
template <class Device>
Picoseconds run(Master& master, Device& device, Picoseconds now, bool late) {
  const bool cdm = master.setup().cdm;
  StepOutput out = master.begin(now, device.level(now), cdm);
  require(master.done() == out.level);
  const Picoseconds begin = now;
  const Picoseconds limit =
      begin + longest(master.setup(), master.codec().payload_bits()) * (late ? 3 : 1);
  const Picoseconds low = master.setup().low_time;
  const Picoseconds shortest = std::min(low, master.setup().period - low);
  Picoseconds edge = now;
  device.tell(out.level, now);
  while (!master.done()) {
    require(out.has_deadline() && out.deadline >= now);
    const Picoseconds due = late ? out.deadline + master.setup().period / 3 : out.deadline;
    now = std::max(now, std::min(due, device.next()));
    require(now <= limit);
    device.tell(out.level, now);
    const StepOutput next = master.step(now, device.level(now));
    if (next.level != out.level) {
      // Only the rise of MA at the end of CDM, caused by SLO, may come sooner.
      require(now - edge >= shortest || (master.done() && next.level));
      edge = now;
    }
    out = next;
    device.tell(out.level, now);
  }
  require(out.level);
  return now;
}

void check(const Master::Reading& reading, const Master& master) {
  if (!reading.frame.ok()) {
    require(!name_of(reading.frame.error().cause).empty());
    require((reading.refusal == Refusal::none) ==
            (reading.frame.error().cause != FrameError::not_ready));
    return;
  }
  const AckBounds ack = request_ack_bounds(master.setup());
  require(reading.refusal == Refusal::none && reading.line_delay.has_value());
  require(*reading.line_delay >= Picoseconds{});
  require(reading.ack_clocks >= ack.min_clocks && reading.ack_clocks <= ack.max_clocks);
  require(reading.clocks >= 3U + reading.ack_clocks + master.codec().payload_bits());
  require(reading.frame->ack_clocks == reading.ack_clocks && reading.frame->stop_seen);
}

// An undisturbed answer of a device is read bit by bit.
void check_script(const Master& master, BitView script) {
  const Master::Reading& reading = master.reading();
  FrameBits bits;
  for (std::size_t i = 0; i < script.size_bits(); ++i) bits.append(script[i]);
  bits.append_run(false, FrameBits::capacity_bits - bits.size_bits());
  const AckBounds ack = request_ack_bounds(master.setup());
  const auto expected = decode_frame(bits.view(), master.codec(),
                                     {.lead_min_clocks = 1,
                                      .lead_max_clocks = FrameBounds{}.lead_max_clocks,
                                      .ack_min_clocks = ack.min_clocks,
                                      .ack_max_clocks = ack.max_clocks});
  if (expected.ok() && reading.frame.ok()) {
    require(expected->channel_list == reading.frame->channel_list);
    require(expected->cds == reading.frame->cds);
    require(expected->ack_clocks == reading.ack_clocks);
    return;
  }
  require(!reading.frame.ok());
  const FrameError cause = reading.frame.error().cause;
  const bool in_time = cause != FrameError::no_response && cause != FrameError::response_range;
  require(!expected.ok() || !in_time);
  if (expected.ok() || !in_time) return;
  // The master does not wait for a START that comes too late.
  const bool too_late =
      expected.error().cause == FrameError::ack_range && cause == FrameError::no_start;
  require(too_late || expected.error() == reading.frame.error());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < header_bytes) return 0;
  const auto& codec = codec_of<Codec>(data[0]);
  const MasterSetup setup = setup_of(data);
  const std::span<const std::uint8_t> bytes(data + header_bytes, size - header_bytes);
  const bool late = (data[2] & 4U) != 0;
  Master master(codec, setup);
  Picoseconds now{};
  if ((data[2] & 8U) == 0) {
    Train train(bytes, setup.period);
    for (int i = 0; i < requests_a_train; ++i) {
      now = std::max(run(master, train, now, late), i % 2 == 0 ? now : master.earliest());
      check(master.reading(), master);
    }
    return 0;
  }
  const BitView bits = BitView(bytes).first(FrameBits::capacity_bits);
  Script script(bits, setup.period * data[7] / 8, setup.timing.timeout.time + 2 * setup.period);
  run(master, script, now, late);
  check(master.reading(), master);
  // Devices answer at the second clock; the master relies on it.
  const bool device = bits.size_bits() > 1 && bits[0] && !bits[1];
  const bool plain = !late && setup.sample_shift.count == 0 && setup.compensate;
  if (plain && device) check_script(master, bits);
  return 0;
}
