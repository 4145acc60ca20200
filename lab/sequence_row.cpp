#include "lab/sequence_row.hpp"

#include <fmt/format.h>

namespace biss::lab {
namespace {

constexpr std::uint64_t undamaged_block = 65'536;
constexpr std::uint64_t event_block = 1'024;

constexpr std::array<std::string_view, 7> corruption{
    "flips:0.5", "flips:0.1", "flips:0.01", "flips:0.001", "burst:8", "burst:16", "burst:32"};
constexpr std::array<std::string_view, 3> repetition{"previous", "older", "any_age"};
constexpr std::array<std::string_view, 3> sequence{"exchanged", "shuffled", "overtaken"};
constexpr std::array<std::string_view, 4> loss{"no_answer", "passed_over", "unheard",
                                               "whole_period"};
constexpr std::array<std::string_view, 3> delay{"watched", "unwatched", "stored"};
constexpr std::array<std::string_view, 2> insertion{"stale", "foreign"};
constexpr std::array<std::string_view, 5> masquerade{"noise", "noise_word", "start_value",
                                                     "polynomial", "standard"};
constexpr std::array<std::string_view, 3> addressing{"one_frame", "for_good", "start_value"};

}  // namespace

std::span<const std::string_view> variants_of(TransmissionError kind) {
  switch (kind) {
    case TransmissionError::corruption:
      return corruption;
    case TransmissionError::repetition:
      return repetition;
    case TransmissionError::sequence:
      return sequence;
    case TransmissionError::loss:
      return loss;
    case TransmissionError::delay:
      return delay;
    case TransmissionError::insertion:
      return insertion;
    case TransmissionError::masquerade:
      return masquerade;
    case TransmissionError::addressing:
      return addressing;
  }
  return {};
}

std::string_view SequenceRow::name() const {
  if (task == SequenceTask::undamaged) return "undamaged";
  if (task == SequenceTask::counter_mode) return "counter_mode";
  return biss::name_of(kind);
}

std::string_view SequenceRow::variant_name() const {
  if (task != SequenceTask::fault) return sequence_motion_names[static_cast<std::size_t>(motion)];
  const auto names = variants_of(kind);
  return variant < names.size() ? names[variant] : "all";
}

std::uint64_t SequenceRow::seed(std::uint64_t campaign_seed) const {
  return row_seed(campaign_seed, fmt::format("{}:{}:{}:{}", name(), variant_name(),
                                             name_of(counter), name_of(encoder_counter)));
}

TrialBlocks SequenceRow::blocks() const {
  return {size, task == SequenceTask::undamaged ? undamaged_block : event_block};
}

}  // namespace biss::lab
