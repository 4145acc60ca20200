#include "verbs/simulate/truth.hpp"

#include <string>

#include "verbs/simulate/fault_option.hpp"

namespace biss::verbs {

FieldRow truth_row(const FrameFormat& format, std::uint64_t number,
                   const sim::SimulatedCycle& cycle, std::string_view faults) {
  FieldRow row{{"cycle", number}, {"time_ns", cycle.time}};
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    // Values that a channel does not have stay empty, as in the rows of `decode`.
    const auto add = [&](std::string name, bool present, auto value) {
      if (k != 0) name += std::to_string(k + 1);
      row.emplace_back(name, present && cycle.taken[k] ? std::optional(value) : std::nullopt);
    };
    const ChannelFormat& channel = format.channel_list[k];
    const Channel& sent = cycle.sent.channel_list[k];
    add("position", channel.position_bits() != 0, sent.position);
    add("nE", channel.error.present, sent.nE);
    add("nW", channel.warning.present, sent.nW);
    if (k == 0) row.emplace_back("faults", unless_empty(faults));
  }
  row.emplace_back("places", unless_empty(text_of(cycle.injected)));
  // No clocks: the request was not made by our master.
  row.emplace_back(
      "marginal", cycle.reading.clocks == 0 ? std::nullopt : std::optional(cycle.reading.marginal));
  row.emplace_back("sampled_ns", cycle.sampled);
  return row;
}

}  // namespace biss::verbs
