#include "verbs/decode/safety.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "biss/frame/format_text.hpp"
#include "biss/safety/configurations.hpp"
#include "verbs/common/decoded_capture.hpp"
#include "verbs/common/verb.hpp"

namespace biss::verbs {

namespace {

void put(const SafetyArguments& arguments, Picoseconds cycle, SafetySetup& setup) {
  setup.latch = arguments.latch;
  if (!arguments.counter.empty()) {
    const auto name =
        std::find(counter_mode_names.begin(), counter_mode_names.end(), arguments.counter);
    setup.counter.mode = static_cast<CounterMode>(name - counter_mode_names.begin());
  }
  const auto small = [](std::uint64_t value) { return static_cast<std::uint8_t>(value); };
  if (arguments.compare_bits) setup.comparison.compare_bits = small(*arguments.compare_bits);
  if (arguments.tolerance) setup.comparison.tolerance_lsb = small(*arguments.tolerance);
  if (arguments.start_frames) setup.start_frames = small(*arguments.start_frames);
  const Picoseconds usual = arguments.any_gap ? Picoseconds{} : setup.frame_gap_min;
  if (cycle.count != 0) {
    // Frames sooner than the encoder permits are all `early`.
    setup = at_cycle(setup, std::max(cycle, setup.frame_gap_min));
    setup.cycle_min = cycle;
  }
  const Picoseconds most = setup.frame_gap_min;
  if (arguments.watchdog) setup.frame_gap_max = *arguments.watchdog;
  setup.frame_gap_min = arguments.shortest.value_or(usual);
  if (arguments.shortest || !may_lose_period(setup)) return;
  // The cycles of a capture vary: no longer than the watchdog needs.
  const Picoseconds needed =
      setup.frame_gap_max / counter_period(setup.counter.mode) + picoseconds(1);
  if (needed <= most) setup.frame_gap_min = needed;
}

std::string counter_text(const decode::SafetyWatch& watch) {
  const std::uint64_t to_0 = watch.rollovers_to_0();
  const std::uint64_t to_1 = watch.rollovers_to_1();
  if (to_0 == 0 && to_1 == 0) return "period not seen";
  if (to_0 != 0 && to_1 != 0) {
    return fmt::format("period unclear: {} times from 63 to 0, {} times to 1", to_0, to_1);
  }
  return fmt::format("period {}, seen {}", to_0 != 0 ? 64 : 63,
                     report::counted(to_0 + to_1, "time"));
}

}  // namespace

std::string_view message_of(SafetySetupError mistake) {
  // In the order of SafetySetupError.
  constexpr auto messages = std::to_array<std::string_view>(
      {"the frame does not have two words", "a word has no CRC", "a word has no nE",
       "a word has no position", "a word's position is in Gray code", "the second word has no lc6",
       "--compare-bits: more than both words have", "--tolerance: accepts every position",
       "--start-frames: 2 or more", "the counter's settings are out of range",
       "the fault budget is out of range",
       "--watchdog: longer than --shortest-gap, at most 100 s, and shorter than 63 times "
       "--shortest-gap (64 times with count_0_63)",
       "the clocks' tolerance is out of range",
       "no number of clocks before the data is within the bounds",
       "the CPW's CRC is not 0x43, or the SPW's is not 0x190D9",
       "fewer than 9 bits are compared, or the tolerance is above 1",
       "no rating for these words and this comparison",
       "more undetected errors an hour than residual_max_e15 permits"});
  static_assert(messages.size() == safety_setup_error_count);
  return messages[static_cast<std::size_t>(mistake)];
}

bool SafetyArguments::given() const {
  return !configuration.empty() || !counter.empty() || compare_bits || tolerance || start_frames ||
         watchdog || shortest || latch;
}

void add_check_options(Verb verb, SafetyArguments& arguments) {
  add_name_option(verb, "--counter", arguments.counter,
                  {counter_mode_names.begin(), counter_mode_names.end()},
                  "Range of the sign-of-life counter; count_1_63 by default");
  add_count_option(verb, "--compare-bits", into(arguments.compare_bits),
                   "Number of upper singleturn bits to compare; 0: all bits that both words have",
                   64);
  add_count_option(
      verb, "--tolerance", into(arguments.tolerance),
      "Largest difference of the two words, in counts of the lowest bit compared; 1 by default",
      255);
  add_count_option(verb, "--start-frames", into(arguments.start_frames),
                   "Number of good frames in a row before a frame is safe; 3 by default", 255);
}

void add_safety_options(Verb verb, SafetyArguments& arguments) {
  verb = verb.scope(Scope::judging);
  std::vector<std::string> names{"off"};
  for (const SafetyConfiguration& each : safety_configurations) names.emplace_back(each.name);
  add_name_option(verb, "--safety", arguments.configuration, names,
                  "Configuration of the safety monitor; by default the one of the format");
  add_check_options(verb, arguments);
  add_duration_option(verb, "--watchdog", into(arguments.watchdog),
                      "Longest time from one good frame to the next; one and a half cycles of the "
                      "capture by default");
  add_duration_option(verb, "--shortest-gap", into(arguments.shortest),
                      "Shortest time from one good frame to the next; 0: not checked. By default "
                      "the shortest cycle of the configuration, less a 32nd, or the 63rd part of "
                      "the watchdog time if that is longer");
  verb.add_flag("--latch", arguments.latch,
                "Keep a fault until the end of the capture, as a monitor in a machine does");
}

tl::expected<SafetyChoice, std::string> choose_safety(const SafetyArguments& arguments,
                                                      std::string_view format_text,
                                                      const FrameFormat& format,
                                                      Picoseconds cycle) {
  SafetyChoice choice{.setup = {}, .name = "by the words' widths"};
  const auto* known = find_safety_configuration(arguments.configuration);
  if (known == nullptr && !arguments.by_widths) known = implied_configuration(format_text, format);
  if (known != nullptr) choice = {.setup = known->setup, .name = std::string(known->name)};
  put(arguments, cycle, choice.setup);
  if (const auto mistake = check_safety(format, UnratedSafetySetup(choice.setup))) {
    return tl::unexpected(fmt::format("BiSS Safety: {}", message_of(*mistake)));
  }
  return choice;
}

tl::expected<std::optional<SafetyChoice>, std::string> choose_monitor(SafetyArguments arguments,
                                                                      std::string format_text,
                                                                      DecodedCapture& capture) {
  const auto& format = capture.format();
  if (!format) {
    if (!arguments.given()) return std::nullopt;
    return tl::unexpected(
        std::string("BiSS Safety: the contents of the words are unknown without -f"));
  }
  if (arguments.configuration == "off") return std::nullopt;
  if (!arguments.given() && !is_safety_format(*format)) return std::nullopt;
  if (format_text.empty()) format_text = biss::format_text(*format).view();
  // The shortest cycle of an encoder without a name is not known.
  arguments.any_gap =
      arguments.configuration.empty() && implied_configuration(format_text, *format) == nullptr;
  return choose_safety(arguments, format_text, *format, capture.interval());
}

void add_safety(report::Summary& summary, const decode::SafetyWatch& watch, std::string_view name) {
  std::string text;
  for (std::size_t i = 0; i < safety_verdict_count; ++i) {
    report::append_count(text, watch.count(verdict_of(i)), name_of(verdict_of(i)));
  }
  const SafetySetup& setup = watch.setup();
  summary.entry("safety", text,
                fmt::format("{}; watchdog {}", name, biss::text_of(setup.frame_gap_max, 3)));
  summary.entry("counter", counter_text(watch),
                fmt::format("judged as {}",
                            counter_mode_names[static_cast<std::size_t>(setup.counter.mode)]));
  if (watch.compared() == 0) return;
  summary.entry("comparison",
                fmt::format("worst difference {}, {} allowed", watch.worst_difference(),
                            setup.comparison.tolerance_lsb),
                fmt::format("in counts of the lowest of {} bits", watch.compared_bits()));
}

}  // namespace biss::verbs
