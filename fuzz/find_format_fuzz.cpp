// The format of a line that nothing is known of: frames of a hostile encoder, or any bits.
#include "biss/frame/codec.hpp"
#include "biss/frame/format_text.hpp"
#include "fuzz/target.hpp"
#include "identify/format.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;
using namespace biss::identify;

// Enough for a format to be sure, few enough for many executions.
constexpr std::size_t most_frames = 32;

struct Story {
  std::vector<Sample> samples;
  /// Without a channel: the frames are any bits.
  FrameFormat format;
};

// Rows may be missing between two frames.
Sample next_sample(const Story& story, unsigned missing) {
  Sample sample;
  if (!story.samples.empty()) sample.cycle = story.samples.back().cycle + 1 + missing;
  sample.time = microseconds(50) * static_cast<std::int64_t>(sample.cycle);
  return sample;
}

Story any_bits(ByteSource& source) {
  Story story;
  const unsigned bits = 1 + source.next() % 120U;
  while (!source.done() && story.samples.size() < most_frames) {
    Sample sample = next_sample(story, 0);
    for (unsigned at = 0; at < bits; at += 8) {
      const unsigned count = std::min(8U, bits - at);
      sample.bits.append(source.next() & low_mask(count), count);
    }
    story.samples.push_back(sample);
  }
  return story;
}

// A channel with a checksum of any polynomial.
FrameFormat any_format(ByteSource& source) {
  FrameFormat format;
  format.channel_count = 1;
  ChannelFormat& channel = format.channel_list[0];
  const unsigned width = min_crc_bits + source.next() % 14U;
  const bool usual = default_polynomial(width) != 0 && source.next() % 2 == 0;
  const std::uint32_t any = 1U | (source.next_16() & low_mask(width)) | 1U << width;
  channel.crc = {.polynomial = usual ? default_polynomial(width) : any,
                 .width_bits = static_cast<std::uint8_t>(width)};
  channel.crc.inverted = source.next() % 4 != 0;
  if (source.next() % 4 == 0) channel.crc.start = source.next_16() & channel.crc.mask();
  channel.data_bits = static_cast<std::uint8_t>(4 + source.next() % 45U);
  channel.position = {.shift = 0, .bits = channel.data_bits};
  return format;
}

// Each frame moves the data by a step, then may be damaged in one bit or come after missing ones.
Story frames_of_format(ByteSource& source) {
  Story story{.samples = {}, .format = any_format(source)};
  const ChannelFormat& channel = story.format.channel_list[0];
  const FrameCodec<> codec(story.format);
  const unsigned shift = source.next() % 16U;
  const unsigned tail = source.next() % 4U;
  std::uint64_t data = std::uint64_t{source.next_16()} << 32U | source.next_16();
  while (!source.done() && story.samples.size() < most_frames) {
    data += std::uint64_t{source.next_16()} << shift;
    const unsigned fate = source.next();
    Sample sample = next_sample(story, fate % 8 == 1 ? fate / 32U : 0);
    sample.bits.append(data & low_mask(channel.data_bits), channel.data_bits);
    sample.bits.append(codec.crc(0, data & low_mask(channel.data_bits), false),
                       channel.crc.width_bits);
    if (fate % 8 == 2) sample.bits.flip(fate / 8U * 7U % sample.bits.size_bits());
    sample.bits.append(0b0011, tail == 0 ? 0 : 4);
    story.samples.push_back(sample);
  }
  return story;
}

void check_candidate(const FormatCandidate& candidate, std::size_t longest) {
  const FrameFormat& format = candidate.format;
  require(candidate.confidence >= 0 && candidate.confidence <= 1);
  require(format.channel_count == candidate.fields.size());
  require(format.channel_count == candidate.layout.channels.size());
  require(format.payload_bits() == candidate.layout.end() && format.payload_bits() <= longest);
  require(candidate.layout.right_share >= 0 && candidate.layout.right_share <= 1);
  const FormatText text = format_text(format);
  const auto again = parse_format(text.view());
  require(again.ok() && *again == format);
}

// A format that decode uses by itself: frames that differ show the checksum, bit by bit.
void check_sure(const FormatFinding& finding, const Story& story) {
  constexpr unsigned least_evidence_bits = 12;
  const auto* const sure = finding.sure();
  if (sure == nullptr) return;
  require(!finding.still && sure == &finding.candidates.front());
  unsigned evidence = 0;
  bool any_motion = false;
  for (const auto& channel : sure->layout.channels) {
    require(channel.crc.present());
    evidence += channel.crc.width_bits * (channel.rank + 1);
    any_motion = any_motion || channel.rank != 0;
  }
  require(any_motion && evidence >= least_evidence_bits);
  require(same_verdicts(sure->format, sure->format, story.samples));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ByteSource source(data, size);
  const Story story = source.next() % 4 == 0 ? any_bits(source) : frames_of_format(source);
  std::size_t longest = 0;
  for (const Sample& sample : story.samples) longest = std::max(longest, sample.bits.size_bits());
  const FormatFinding finding = find_format(story.samples);
  for (const auto& candidate : finding.candidates) check_candidate(candidate, longest);
  check_sure(finding, story);
  return 0;
}
