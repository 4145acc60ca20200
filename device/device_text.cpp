#include "device/device_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "device/nearest.hpp"
#include "device/quantity.hpp"

namespace biss {
namespace {

tl::unexpected<std::string> wrong(std::string error) {
  return tl::make_unexpected(std::move(error));
}

std::string shortened(std::string_view text, std::size_t most) {
  if (text.size() <= most) return std::string(text);
  return fmt::format("{}...", text.substr(0, most));
}

// The full form of a polynomial without its top or its last bit; empty if it lacks neither.
std::string full_forms(std::string_view text, std::size_t at) {
  const std::size_t end = std::min(text.find_first_of(":,+;", at), text.size());
  const std::string_view digits = text.substr(at, end - at);
  const std::string_view before = text.substr(0, at - 1);
  const auto number = parse_count(digits, 0xFFFFFF);
  const auto width = parse_count(before.substr(before.rfind("crc") + 3), max_crc_bits);
  if (!number.ok() || !width.ok()) return {};
  const auto polynomial = static_cast<std::uint32_t>(*number);
  const auto bits = static_cast<unsigned>(*width);
  std::vector<std::string> forms;
  for (const auto& [form, added] :
       {std::pair{polynomial | (1U << bits), "top"}, std::pair{polynomial << 1U | 1U, "last"}}) {
    if (polynomial >= (1U << bits) || !is_full_form(form, bits)) continue;
    forms.push_back(fmt::format("0x{:X} with the {} bit added{}", form, added,
                                form == default_polynomial(bits) ? " (the default of BiSS)" : ""));
  }
  return forms.empty() ? "" : fmt::format("; write {}", fmt::join(forms, " or "));
}

// One line: the text, the mistake, its place, and the item there.
std::string grammar_error(std::string_view text, FormatTextError error) {
  const std::string_view said = text_of(error.mistake);
  const std::size_t split = std::min(said.find(';'), said.size());
  std::string where;
  if (error.mistake == FormatMistake::empty) {
    where = "; write items like pos26,nE,nW,crc6 or a name that 'biss encoders' lists";
  } else if (error.at >= text.size()) {
    where = " at the end";
  } else {
    const std::string_view rest = text.substr(error.at);
    const std::string_view token =
        rest.substr(0, std::max<std::size_t>(rest.find_first_of(",+;"), 1));
    where = fmt::format(" at character {} (\"{}\")", error.at + 1, shortened(token, 24));
    if (error.mistake == FormatMistake::polynomial_form) where += full_forms(text, error.at);
  }
  return fmt::format("format \"{}\": {}{}{}", shortened(text, 72), said.substr(0, split), where,
                     said.substr(split));
}

std::string name_error(std::string_view text) {
  const std::string names = suggested_encoders(text);
  return fmt::format("format \"{}\": no such name or item{} ('biss encoders' lists the names)",
                     shortened(text, 72),
                     names.empty() ? "" : fmt::format("; did you mean {}?", names));
}

std::string option_error(std::string_view option, Quantity quantity, std::string_view text,
                         QuantityError error) {
  return fmt::format("{} {}", option, quantity_error_text(quantity, text, error));
}

std::string read_duration(std::string_view option, std::string_view text, Picoseconds& time) {
  const auto parsed = parse_duration(text);
  if (!parsed.ok()) return option_error(option, Quantity::duration, text, parsed.error());
  time = *parsed;
  return {};
}

// Each reads the options that it names, if they are given; else the timing stays as it is.
std::string read_timeout(const FormatArguments& arguments, DeviceTiming& timing) {
  const std::string_view text = arguments.timeout;
  if (text.empty()) return {};
  const std::size_t colon = std::min(text.find(':'), text.size());
  const std::string_view rule = text.substr(0, colon);
  const bool has_time = colon != text.size();
  if (rule == "adaptive") {
    timing.timeout = {TimeoutRule::adaptive, {}};
  } else if (rule == "static" && has_time) {
    timing.timeout = {TimeoutRule::fixed, {}};
  } else if (rule == "cycle" && has_time) {
    timing.timeout = {TimeoutRule::cycle, {}};
  } else {
    return fmt::format(
        "--timeout \"{}\": no such rule; write adaptive, static:20us or cycle:31.25us",
        shortened(text, 40));
  }
  return has_time ? read_duration("--timeout", text.substr(colon + 1), timing.timeout.time) : "";
}

std::string read_release(const FormatArguments& arguments, DeviceTiming& timing) {
  if (arguments.release.empty()) return {};
  const auto halves = parse_count(arguments.release, UINT8_MAX);
  if (!halves.ok() || *halves < biss_release_half_periods_min) {
    return fmt::format("--release '{}': must be a number from {} to {}, in half periods of MA",
                       shortened(arguments.release, 40), biss_release_half_periods_min, UINT8_MAX);
  }
  timing.timeout.release_half_periods = static_cast<std::uint8_t>(*halves);
  return {};
}

std::string read_clock_max(const FormatArguments& arguments, DeviceTiming& timing) {
  const std::string& text = arguments.clock_max;
  if (text.empty()) return {};
  const auto rate = parse_rate(text);
  if (!rate.ok()) return option_error("--clock-max", Quantity::rate, text, rate.error());
  if (*rate < timing.clock_min) {
    return fmt::format("--clock-max '{}': below the device's lowest clock of {}", text,
                       text_of(timing.clock_min));
  }
  timing.clock_max = *rate;
  return {};
}

std::string read_cycle_min(const FormatArguments& arguments, DeviceTiming& timing) {
  if (arguments.cycle_min.empty()) return {};
  return read_duration("--cycle-min", arguments.cycle_min, timing.cycle_min);
}

std::string read_ack(const FormatArguments& arguments, DeviceTiming& timing) {
  if (!arguments.ack_max.empty() && !arguments.ack_clocks.empty()) {
    return "--ack-max and --ack-clocks exclude each other: ACK has a limit or a fixed length";
  }
  if (!arguments.ack_max.empty()) {
    std::string error = read_duration("--ack-max", arguments.ack_max, timing.ack_max);
    if (!error.empty()) return error;
    if (timing.ack_max > biss_busy_max) {
      return fmt::format("--ack-max '{}': too long; BiSS C allows 40 us", arguments.ack_max);
    }
    timing.ack_clocks = 0;
  }
  if (!arguments.ack_clocks.empty()) {
    const auto clocks = parse_count(arguments.ack_clocks, biss_ack_max_clocks);
    if (!clocks.ok() || *clocks == 0) {
      return fmt::format("--ack-clocks '{}': must be a number from 1 to {}",
                         shortened(arguments.ack_clocks, 40), biss_ack_max_clocks);
    }
    timing.ack_clocks = static_cast<std::uint16_t>(*clocks);
  }
  return {};
}

}  // namespace

tl::expected<Device, std::string> parse_device(std::string_view text) {
  const auto device = read_device(text);
  if (device.ok()) return *device;
  const DeviceTextError error = device.error();
  if (error.mistake == DeviceMistake::item) return wrong(grammar_error(text, error.item));
  if (error.mistake == DeviceMistake::name) return wrong(name_error(text));
  const ProfileIdentifier identifier = error.identifier;
  std::string why(biss::text_of(error));
  if (error.mistake == DeviceMistake::other_profile) {
    why =
        fmt::format("this identifier is of profile {}, not of BP3", name_of(identifier.profile()));
  } else if (error.mistake == DeviceMistake::no_position) {
    why = fmt::format("the data length {} leaves no position", identifier.data_length());
  }
  return wrong(fmt::format("format \"{}\": {}", shortened(text, 72), why));
}

tl::expected<Device, std::string> choose_device(const FormatArguments& arguments) {
  auto device = parse_device(arguments.format);
  if (!device) return device;
  auto timing = override_timing(arguments, device->timing);
  if (!timing) return wrong(std::move(timing.error()));
  device->timing = *timing;
  return device;
}

tl::expected<DeviceTiming, std::string> override_timing(const FormatArguments& arguments,
                                                        DeviceTiming timing) {
  for (const auto read : {read_ack, read_timeout, read_release, read_clock_max, read_cycle_min}) {
    if (std::string error = read(arguments, timing); !error.empty()) return wrong(std::move(error));
  }
  return timing;
}

std::string text_of(const Timeout& timeout) {
  std::string time = text_of(timeout.time);
  std::erase(time, ' ');
  switch (timeout.rule) {
    case TimeoutRule::adaptive:
      return timeout.time == Picoseconds{} ? "adaptive" : "adaptive:" + time;
    case TimeoutRule::fixed:
      return "static:" + time;
    case TimeoutRule::cycle:
      return "cycle:" + time;
  }
  return {};
}

std::string suggested_encoders(std::string_view name) {
  constexpr std::size_t most = 3;
  if (name.size() < 2) return {};
  std::string wanted(name);
  for (char& c : wanted) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  std::vector<std::string> names;
  std::vector<std::string> longer;
  const auto add = [&](std::string_view known) {
    names.emplace_back(known);
    if (known.starts_with(wanted) && longer.size() < most) longer.push_back(names.back());
  };
  for (const CatalogueEntry& entry : catalogue) add(entry.name);
  for (const SafetyConfiguration& each : safety_configurations) {
    if (find_encoder(each.name) == nullptr) add(each.name);
  }
  return longer.empty() ? nearest(wanted, names) : fmt::format("{}", fmt::join(longer, ", "));
}

}  // namespace biss
