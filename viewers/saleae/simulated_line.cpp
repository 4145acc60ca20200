#include "viewers/saleae/simulated_line.hpp"

#include "biss/base/bits.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"

namespace logic {

namespace {

constexpr biss::FrameFormat usual_format = *biss::parse_format("pos26,nE,nW,crc6");
// The step from one request to the next is the range of positions, shifted right by this.
constexpr unsigned step_shift = 10;

BitState level_of(bool high) { return high ? BIT_HIGH : BIT_LOW; }

}  // namespace

SimulatedLine::SimulatedLine(Settings& settings, U32 sample_rate)
    : codec_(settings.rows().format.value_or(usual_format)), setup_(settings.rows()) {
  ma_ = group_.Add(settings.ma(), sample_rate, level_of(!setup_.ma_inverted));
  slo_ = group_.Add(settings.slo(), sample_rate, level_of(!setup_.slo_inverted));
  group_.AdvanceAll(idle_half_clocks * samples_per_half_clock);
}

U32 SimulatedLine::run_until(U64 sample, SimulationChannelDescriptor** channels) {
  while (ma_->GetCurrentSampleNumber() < sample) write_cycle();
  *channels = group_.GetArray();
  return group_.GetCount();
}

void SimulatedLine::write_cycle() {
  const biss::FrameFormat& format = codec_.format();
  biss::Frame frame;
  frame.channel_count = format.channel_count;
  frame.lead_clocks = 1;
  frame.ack_clocks = ack_clocks;
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const unsigned bits = format.channel_list[k].position_bits();
    frame.channel_list[k].position = position_ & biss::low_mask(bits);
    frame.channel_list[k].nE = true;
    frame.channel_list[k].nW = true;
  }
  const unsigned bits = format.channel_list[0].position_bits();
  position_ += bits > step_shift ? std::uint64_t{1} << (bits - step_shift) : 1;

  const auto answer = biss::encode_frame(frame, codec_);
  if (!answer.ok()) return group_.AdvanceAll(idle_half_clocks * samples_per_half_clock);
  for (std::size_t i = 0; i < answer->size_bits(); ++i) put_clock(answer->view()[i]);
  group_.AdvanceAll(4 * samples_per_half_clock);
  put_slo(true);
  group_.AdvanceAll(idle_half_clocks * samples_per_half_clock);
}

// MA falls and rises; SLO changes after the rising edge.
void SimulatedLine::put_clock(bool slo) {
  ma_->Transition();
  group_.AdvanceAll(samples_per_half_clock);
  ma_->Transition();
  group_.AdvanceAll(1);
  put_slo(slo);
  group_.AdvanceAll(samples_per_half_clock - 1);
}

void SimulatedLine::put_slo(bool level) {
  slo_->TransitionIfNeeded(level_of(level != setup_.slo_inverted));
}

}  // namespace logic
