// The slave on any train of edges: no state lasts longer than its timeout, and it answers the next
// request.
//
// Input: the format's number in frame_formats; bits 0 and 1 the timeout's rule, bit 2 chained, bits
// 3…7 busy_s and the fixed ACK; sampling, ready and the timeout, each a byte; the clock period in
// steps of 50 ns above 100 ns; then one byte for each event: bits 0…5 the time to it in eighths of
// a period and 1 ns, 63 a long pause; bit 6 inverts MA, bit 7 inverts SLI.
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/slave/slave.hpp"
#include "fuzz/frame_formats.hpp"
#include "fuzz/target.hpp"

namespace {

using biss::Picoseconds;
using biss::fuzz::require;
using Codec = biss::FrameCodec<biss::CrcTable<4>>;

constexpr std::size_t header_bytes = 6;
constexpr Picoseconds least_pause = biss::nanoseconds(1);

/// Counts positions up, and checks the time of each call.
struct Owner {
  const biss::FrameFormat* format = nullptr;
  std::uint64_t samples = 0;
  std::optional<Picoseconds> last{};

  std::uint64_t position(std::size_t k) const {
    const std::uint64_t value = samples * 0x9E37'79B9'7F4A'7C15U;
    return value & biss::low_mask(format->channel_list[k].position_bits());
  }
  Codec::Frame sample(Picoseconds moment) {
    require(!last || *last <= moment);
    last = moment;
    ++samples;
    Codec::Frame frame;
    for (std::size_t k = 0; k < format->channel_count; ++k) {
      frame.channel_list[k].position = position(k);
    }
    return frame;
  }
  bool cds(bool predecessor) const { return predecessor; }
  void cdm(bool) const {}
};

using Slave = biss::Slave<Codec, Owner>;

biss::SlaveTiming timing_of(const std::uint8_t* header, Picoseconds period) {
  constexpr std::array rules{biss::TimeoutRule::fixed, biss::TimeoutRule::adaptive,
                             biss::TimeoutRule::cycle, biss::TimeoutRule::fixed};
  const biss::TimeoutRule rule = rules[header[1] % 4U];
  Picoseconds time = biss::nanoseconds(12'500 + 100 * header[4]);
  if (rule == biss::TimeoutRule::adaptive) time = biss::nanoseconds(header[4]);
  // A cycle is longer than the 1.5 periods up to ACK.
  if (rule == biss::TimeoutRule::cycle) time = biss::nanoseconds(16'000 + 100 * header[4]);
  return {.sampling = period * (header[2] % 64U) / 8,
          .start_min = period * (header[2] / 64U),
          .ready = period * header[3] / 8,
          .ack_clocks = static_cast<std::uint16_t>(header[1] >= 128 ? header[1] % 16U : 0U),
          .busy_s_clocks = static_cast<std::uint8_t>((header[1] >> 3U) % 8U),
          .timeout = {rule, time},
          .chained = (header[1] & 4U) != 0};
}

/// Drives the slave and checks the contract of each step.
class Line {
 public:
  explicit Line(Slave& slave) : slave_(slave) {}

  void step(bool ma, bool sli) {
    ma_ = ma;
    sli_ = sli;
    put();
  }
  void wait(Picoseconds time) {
    const Picoseconds end = now_ + time;
    while (out_.deadline <= end) {
      require(out_.deadline >= now_);
      now_ = out_.deadline;
      put();
      require(out_.deadline > now_);
    }
    now_ = end;
  }
  const biss::StepOutput& out() const { return out_; }
  bool ma() const { return ma_; }
  bool sli() const { return sli_; }

 private:
  void put() {
    out_ = slave_.step(now_, ma_, sli_);
    const biss::SlaveState state = slave_.state();
    const bool idle = state == biss::SlaveState::idle;
    if (idle || state < biss::SlaveState::ack) require(out_.level);
    if (state == biss::SlaveState::ack || state == biss::SlaveState::chain_busy) {
      require(!out_.level);
    }
    require(out_.has_deadline() == !(idle || state == biss::SlaveState::chain_busy));
    // Another call at the same time does nothing.
    require(slave_.step(now_, ma_, sli_) == out_);
  }

  Slave& slave_;
  biss::StepOutput out_;
  Picoseconds now_ = biss::microseconds(1);
  bool ma_ = true;
  bool sli_ = true;
};

// The next request on an idle line; a predecessor, if any, answers immediately with zeros.
void check_answer(Slave& slave, Line& line, Picoseconds period) {
  const Codec& codec = slave.codec();
  const bool chained = slave.timing().chained;
  const std::uint64_t samples = slave.source().samples;
  biss::BitBuffer<biss::max_frame_bits> bits;
  const unsigned clocks = codec.payload_bits() + 120;
  for (unsigned i = 1; i <= clocks && !bits.overflowed(); ++i) {
    line.step(false, line.sli());
    line.wait(period / 2);
    line.step(true, chained && (i == 1 || i == 3));
    line.wait(period / 2);
    bits.append(line.out().level);
  }
  require(slave.source().samples == samples + 1);
  const auto frame = decode_frame(bits.view(), codec, biss::FrameBounds{});
  require(frame.ok());
  for (std::size_t k = 0; k < codec.format().channel_count; ++k) {
    require(frame->channel_list[k].position == slave.source().position(k));
  }
  // Zeros up to the last clock.
  const std::size_t stop = std::size_t{frame->lead_clocks} + frame->ack_clocks + 2U;
  require(bits.view().find(true, stop + codec.payload_bits()) == bits.size_bits());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < header_bytes) return 0;
  const auto& codec = biss::fuzz::codec_of<Codec>(data[0]);
  const Picoseconds period = biss::nanoseconds(100 + 50 * (data[5] % 200));
  Slave slave(codec, timing_of(data, period), Owner{&codec.format()});
  Line line(slave);
  for (const std::uint8_t* at = data + header_bytes; at != data + size; ++at) {
    const unsigned eighths = *at & 63U;
    line.wait(eighths == 63 ? biss::microseconds(45) : period * eighths / 8 + least_pause);
    line.step(line.ma() != ((*at & 64U) != 0), line.sli() != ((*at & 128U) != 0));
  }
  // MA is high, and SLI as at the end of every request, for longer than any timeout.
  line.step(true, slave.timing().chained);
  line.wait(biss::microseconds(45));
  require(slave.state() == biss::SlaveState::idle && line.out().level);
  check_answer(slave, line, period);
  line.step(true, slave.timing().chained);
  line.wait(biss::microseconds(45));
  require(slave.state() == biss::SlaveState::idle);
  return 0;
}
