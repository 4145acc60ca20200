#include "simulators/settings.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "biss/configure/named_device.hpp"
#include "biss/timing/device_timing.hpp"
#include "capi/device.hpp"
#include "device/quantity.hpp"

namespace biss::simulators {

namespace {

using Failed = tl::unexpected<std::string>;
using Checked = tl::expected<void, std::string>;
using biss::Quantity;

std::vector<std::string_view> split(std::string_view text, std::string_view separators) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find_first_of(separators);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

tl::expected<Picoseconds, std::string> read_duration(std::string_view text, Picoseconds longest) {
  const auto value = biss::parse_duration(text);
  if (!value.ok()) {
    return Failed(biss::quantity_error_text(Quantity::duration, text, value.error()));
  }
  if (*value > longest) {
    return Failed(fmt::format("'{}' is longer than {}", text, biss::text_of(longest)));
  }
  return *value;
}

template <std::int64_t longest_ps>
tl::expected<Picoseconds, std::string> read_up_to(std::string_view text) {
  return read_duration(text, picoseconds(longest_ps));
}

tl::expected<Hertz, std::string> read_clock(std::string_view text) {
  const auto value = biss::parse_rate(text);
  if (!value.ok()) return Failed(biss::quantity_error_text(Quantity::rate, text, value.error()));
  if (*value < biss_clock_min || *value > biss_clock_max) {
    return Failed(fmt::format("'{}' is not a clock of BiSS C, 80 kHz to 10 MHz", text));
  }
  return *value;
}

template <std::uint64_t largest = UINT64_MAX>
tl::expected<std::uint64_t, std::string> read_count(std::string_view text) {
  const auto value = biss::parse_count(text, largest);
  if (!value.ok()) {
    return Failed(biss::quantity_error_text(Quantity::count, text, value.error(), largest));
  }
  return *value;
}

template <class Value>
struct Word {
  std::string_view name;
  Value value{};
};

// A fault, and the cause that a master must report for it.
struct FaultWord {
  std::string_view name;
  Fault value{};
  biss_cause cause{};
};

constexpr Word<PositionKind> position_words[] = {{"max", PositionKind::largest},
                                                 {"walk", PositionKind::walk},
                                                 {"ramp", PositionKind::ramp},
                                                 {"random", PositionKind::random}};
constexpr Word<Flags> flag_words[] = {
    {"none", {true, true}}, {"nE", {false, true}}, {"nW", {true, false}}, {"both", {false, false}}};
// In the order of Fault.
constexpr FaultWord fault_words[] = {{"none", Fault::none, BISS_CAUSE_OK},
                                     {"flip", Fault::flip, BISS_CAUSE_CRC},
                                     {"flip_crc", Fault::flip_crc, BISS_CAUSE_CRC},
                                     {"burst", Fault::burst, BISS_CAUSE_CRC},
                                     {"crc_polarity", Fault::crc_polarity, BISS_CAUSE_CRC},
                                     {"no_answer", Fault::no_answer, BISS_CAUSE_NO_RESPONSE},
                                     {"early_ack", Fault::early_ack, BISS_CAUSE_RESPONSE_RANGE},
                                     {"slo_low", Fault::slo_low, BISS_CAUSE_NO_START},
                                     {"cds_high", Fault::cds_high, BISS_CAUSE_CDS},
                                     {"stop_high", Fault::stop_high, BISS_CAUSE_STOP_BIT}};
constexpr Word<bool> bit_words[] = {{"0", false}, {"1", true}};

template <const auto& words>
auto read_word(std::string_view text) -> tl::expected<decltype(words[0].value), std::string> {
  std::string names;
  for (const auto& word : words) {
    if (word.name == text) return word.value;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", word.name);
  }
  return Failed(fmt::format("no '{}'; choose from {}", text, names));
}

tl::expected<PositionChoice, std::string> read_position(std::string_view text) {
  if (!text.empty() && text[0] >= '0' && text[0] <= '9') {
    return read_count<>(text).map([](std::uint64_t number) {
      return PositionChoice{PositionKind::number, number};
    });
  }
  return read_word<position_words>(text).map([](PositionKind kind) {
    return PositionChoice{kind, 0};
  });
}

// `0x42:621A`: an address, and the bytes from there on.
Checked read_registers(std::string_view text, Settings& settings) {
  const auto wrong = [&] {
    return Failed(fmt::format("'{}' is not ADDRESS:BYTES, such as 0x42:621A", text));
  };
  for (const std::string_view part : split(text, ",")) {
    const std::size_t colon = part.find(':');
    const std::string_view bytes = part.substr(std::min(part.size(), colon + 1));
    if (colon == std::string_view::npos || bytes.empty() || bytes.size() % 2 != 0) return wrong();
    const auto first = read_count<127>(part.substr(0, colon));
    if (!first) return Failed(first.error());
    if (*first + bytes.size() / 2 > 128) return Failed("the last register is 127");
    for (std::size_t k = 0; k < bytes.size() / 2; ++k) {
      const auto value = read_count<255>(fmt::format("0x{}", bytes.substr(2 * k, 2)));
      if (!value) return wrong();
      settings.registers[static_cast<std::uint8_t>(*first + k)] = static_cast<std::uint8_t>(*value);
    }
  }
  return {};
}

Checked read_format(std::string_view text, Settings& settings) {
  settings.format_text = text;
  const auto device = read_device(text);
  if (!device.ok()) {
    return Failed(fmt::format("'{}': at character {}: {}", text, device.error().item.at + 1,
                              biss::text_of(device.error())));
  }
  settings.format = device->format;
  settings.device = capi::as_c(device->format, device->timing);
  if (settings.format.needs_previous()) return Failed(":previous: a frame alone cannot be checked");
  return {};
}

// `20us`: fixed; `adaptive`, with the known time that the encoder adds to 1.5 periods;
// `adaptive:60ns`.
Checked read_timeout(std::string_view text, Settings& settings) {
  biss_timing& timing = settings.device.timing;
  constexpr std::string_view adaptive = "adaptive";
  if (text == adaptive) {
    if (timing.timeout.rule != BISS_TIMEOUT_ADAPTIVE) timing.timeout.time_ps = 0;
    timing.timeout.rule = BISS_TIMEOUT_ADAPTIVE;
    return {};
  }
  const bool is_adaptive = text.starts_with(adaptive) && text[adaptive.size()] == ':';
  const auto time =
      read_duration(is_adaptive ? text.substr(adaptive.size() + 1) : text, biss_static_timeout_max);
  if (!time) return Failed(time.error());
  if (!is_adaptive && *time < biss_static_timeout_min) {
    return Failed(fmt::format("'{}' is shorter than {}, the shortest fixed timeout of BiSS C", text,
                              biss::text_of(biss_static_timeout_min)));
  }
  timing.timeout.rule = is_adaptive ? BISS_TIMEOUT_ADAPTIVE : BISS_TIMEOUT_FIXED;
  timing.timeout.time_ps = time->count;
  return {};
}

// One value, or a list of values, each read by `read`.
template <auto member, auto read>
Checked read_one(std::string_view text, Settings& settings) {
  return read(text).map([&](const auto& value) { settings.*member = value; });
}

template <class Value, class Read>
Checked read_parts(std::string_view text, std::vector<Value>& list, Read read) {
  list.clear();
  for (const std::string_view part : split(text, ",")) {
    const auto value = read(part);
    if (!value) return Failed(value.error());
    list.push_back(*value);
  }
  return {};
}

template <auto member, auto read>
Checked read_list(std::string_view text, Settings& settings) {
  return read_parts(text, settings.*member, read);
}

Checked read_processing(std::string_view text, Settings& settings) {
  return read_parts(text, settings.processing, [&](std::string_view part) {
    return read_duration(part, picoseconds(settings.device.timing.ack_max_ps));
  });
}

// A setting of one role, or of both.
struct Setting {
  std::string_view name;
  std::optional<Role> role;
  Checked (*read)(std::string_view text, Settings& settings);
};

constexpr Setting setting_list[] = {
    {"timeout", {}, read_timeout},
    {"line_delay", {}, read_list<&Settings::line_delays, read_up_to<biss_line_delay_max.count>>},
    {"jitter", {}, read_one<&Settings::jitter, read_up_to<microseconds(1).count>>},
    {"seed", {}, read_one<&Settings::seed, read_count<>>},
    {"clock", Role::master, read_list<&Settings::clocks, read_clock>},
    {"pause", Role::master, read_list<&Settings::pauses, read_up_to<milliseconds(100).count>>},
    {"cdm", Role::master, read_list<&Settings::cdm, read_word<bit_words>>},
    {"processing", Role::encoder, read_processing},
    {"positions", Role::encoder, read_list<&Settings::positions, read_position>},
    {"flags", Role::encoder, read_list<&Settings::flags, read_word<flag_words>>},
    {"faults", Role::encoder, read_list<&Settings::faults, read_word<fault_words>>},
    {"registers", Role::encoder, read_registers}};

// Checks values that depend on several settings.
Checked check(const Settings& settings) {
  const auto channels = settings.format.channels();
  for (const auto& [name, fault, cause] : fault_words) {
    if (cause != BISS_CAUSE_CRC || has_crcs(settings.format)) continue;
    if (std::find(settings.faults.begin(), settings.faults.end(), fault) != settings.faults.end()) {
      return Failed(fmt::format(
          "faults: {} needs a CRC in each channel: without it the fault cannot be detected", name));
    }
  }
  unsigned widest = 0;
  for (const ChannelFormat& channel : channels) widest = std::max(widest, channel.position_bits());
  for (const PositionChoice& choice : settings.positions) {
    if (choice.kind == PositionKind::number && (choice.number & ~low_mask(widest)) != 0) {
      return Failed(fmt::format("positions: {} does not fit into {} bits", choice.number, widest));
    }
  }
  if (!settings.registers.empty() && settings.processing.size() > 1) {
    return Failed("registers: one processing time only: the control communication runs on");
  }
  if (!settings.registers.empty() && settings.format.cds0) {
    return Failed("registers: not with cds0 in the format: their answers are in CDS");
  }
  return {};
}

}  // namespace

bool has_crcs(const FrameFormat& format) {
  const auto channels = format.channels();
  return std::all_of(channels.begin(), channels.end(),
                     [](const ChannelFormat& channel) { return channel.crc.present(); });
}

biss_cause cause_of(Fault fault, bool cds0) {
  if (fault == Fault::cds_high && !cds0) return BISS_CAUSE_OK;
  return fault_words[static_cast<std::size_t>(fault)].cause;
}

tl::expected<Settings, std::string> read_settings(Role role, std::string_view text) {
  std::map<std::string_view, std::string_view> pairs;
  for (const std::string_view part : split(text, " \t\n")) {
    if (part.empty()) continue;
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos) {
      return Failed(fmt::format("'{}' is not NAME=VALUE", part));
    }
    if (!pairs.emplace(part.substr(0, equals), part.substr(equals + 1)).second) {
      return Failed(fmt::format("{} is given twice", part.substr(0, equals)));
    }
  }
  const auto format = pairs.extract("format");
  if (!format) return Failed("format is missing");
  Settings settings;
  if (auto read = read_format(format.mapped(), settings); !read) {
    return Failed(fmt::format("format: {}", read.error()));
  }
  for (const auto& [key, value] : pairs) {
    const auto setting = std::find_if(std::begin(setting_list), std::end(setting_list),
                                      [&, name = key](const Setting& one) {
                                        return one.name == name && one.role.value_or(role) == role;
                                      });
    if (setting == std::end(setting_list)) return Failed(fmt::format("no setting '{}'", key));
    const auto read = setting->read(value, settings);
    if (!read) return Failed(fmt::format("{}: {}", key, read.error()));
  }
  if (auto checked = check(settings); !checked) return Failed(checked.error());
  return settings;
}

}  // namespace biss::simulators
