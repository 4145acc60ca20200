#include "simulators/settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <utility>

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

// A list of values, each read by `read`, which returns an expected value.
template <class Value, class Read>
Checked read_list(std::string_view text, std::vector<Value>& list, Read read) {
  list.clear();
  for (const std::string_view part : split(text, ",")) {
    auto value = read(part);
    if (!value) return Failed(value.error());
    list.push_back(*value);
  }
  return {};
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

auto durations(Picoseconds longest) {
  return [longest](std::string_view text) { return read_duration(text, longest); };
}

tl::expected<Hertz, std::string> read_clock(std::string_view text) {
  const auto value = biss::parse_rate(text);
  if (!value.ok()) return Failed(biss::quantity_error_text(Quantity::rate, text, value.error()));
  if (*value < biss_clock_min || *value > biss_clock_max) {
    return Failed(fmt::format("'{}' is not a clock of BiSS C, 80 kHz to 10 MHz", text));
  }
  return *value;
}

tl::expected<std::uint64_t, std::string> read_count(std::string_view text,
                                                    std::uint64_t largest = UINT64_MAX) {
  const auto value = biss::parse_count(text, largest);
  if (!value.ok()) {
    return Failed(biss::quantity_error_text(Quantity::count, text, value.error(), largest));
  }
  return *value;
}

// One of a few words.
template <class Value, std::size_t Count>
tl::expected<Value, std::string> read_word(
    std::string_view text, const std::array<std::pair<std::string_view, Value>, Count>& words) {
  std::string names;
  for (const auto& [name, value] : words) {
    if (name == text) return value;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", name);
  }
  return Failed(fmt::format("no '{}'; choose from {}", text, names));
}

constexpr std::array<std::pair<std::string_view, PositionKind>, 4> position_words{
    {{"max", PositionKind::largest},
     {"walk", PositionKind::walk},
     {"ramp", PositionKind::ramp},
     {"random", PositionKind::random}}};
constexpr std::array<std::pair<std::string_view, Flags>, 4> flag_words{{{"none", {true, true}},
                                                                        {"nE", {false, true}},
                                                                        {"nW", {true, false}},
                                                                        {"both", {false, false}}}};
constexpr std::array<std::pair<std::string_view, Fault>, 10> fault_words{
    {{"none", Fault::none},
     {"flip", Fault::flip},
     {"flip_crc", Fault::flip_crc},
     {"burst", Fault::burst},
     {"crc_polarity", Fault::crc_polarity},
     {"no_answer", Fault::no_answer},
     {"early_ack", Fault::early_ack},
     {"slo_low", Fault::slo_low},
     {"cds_high", Fault::cds_high},
     {"stop_high", Fault::stop_high}}};
constexpr std::array<std::pair<std::string_view, bool>, 2> bit_words{{{"0", false}, {"1", true}}};

tl::expected<PositionChoice, std::string> read_position(std::string_view text) {
  if (!text.empty() && text[0] >= '0' && text[0] <= '9') {
    return read_count(text).map([](std::uint64_t number) {
      return PositionChoice{PositionKind::number, number};
    });
  }
  return read_word(text, position_words).map([](PositionKind kind) {
    return PositionChoice{kind, 0};
  });
}

// `0x42:621A`: an address, and the bytes from there on.
Checked read_registers(std::string_view text, std::map<std::uint8_t, std::uint8_t>& registers) {
  const auto wrong = [&] {
    return Failed(fmt::format("'{}' is not ADDRESS:BYTES, such as 0x42:621A", text));
  };
  for (const std::string_view part : split(text, ",")) {
    const std::size_t colon = part.find(':');
    const std::string_view bytes = part.substr(std::min(part.size(), colon + 1));
    if (colon == std::string_view::npos || bytes.empty() || bytes.size() % 2 != 0) return wrong();
    const auto first = read_count(part.substr(0, colon), 127);
    if (!first) return Failed(first.error());
    if (*first + bytes.size() / 2 > 128) return Failed("the last register is 127");
    for (std::size_t k = 0; k < bytes.size() / 2; ++k) {
      const auto value = read_count(fmt::format("0x{}", bytes.substr(2 * k, 2)), 255);
      if (!value) return wrong();
      registers[static_cast<std::uint8_t>(*first + k)] = static_cast<std::uint8_t>(*value);
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
  settings.timing = capi::as_c(device->timing);
  if (settings.format.needs_previous()) return Failed(":previous: a frame alone cannot be checked");
  return {};
}

// `20us`: fixed; `adaptive`, with the known time that the encoder adds to 1.5 periods;
// `adaptive:60ns`.
Checked read_timeout(std::string_view text, biss_timing& timing) {
  constexpr std::string_view adaptive = "adaptive";
  if (text == adaptive) {
    if (timing.timeout_rule != BISS_TIMEOUT_ADAPTIVE) timing.timeout_ps = 0;
    timing.timeout_rule = BISS_TIMEOUT_ADAPTIVE;
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
  timing.timeout_rule = is_adaptive ? BISS_TIMEOUT_ADAPTIVE : BISS_TIMEOUT_FIXED;
  timing.timeout_ps = time->count;
  return {};
}

// Reads one setting; false: there is none of this name.
tl::expected<bool, std::string> read_setting(Role role, std::string_view key, std::string_view text,
                                             Settings& out) {
  const auto done = [](const Checked& checked) -> tl::expected<bool, std::string> {
    if (!checked) return Failed(checked.error());
    return true;
  };
  if (key == "format") return true;  // was read first
  if (key == "timeout") return done(read_timeout(text, out.timing));
  if (key == "line_delay") {
    return done(read_list(text, out.line_delays, durations(biss_line_delay_max)));
  }
  if (key == "jitter") {
    return read_duration(text, microseconds(1)).map([&](Picoseconds value) {
      out.jitter = value;
      return true;
    });
  }
  if (key == "seed") {
    return read_count(text).map([&](std::uint64_t value) {
      out.seed = value;
      return true;
    });
  }
  if (role == Role::master) {
    if (key == "clock") return done(read_list(text, out.clocks, read_clock));
    if (key == "pause") return done(read_list(text, out.pauses, durations(milliseconds(100))));
    if (key == "cdm") {
      return done(read_list(text, out.cdm, [](auto part) { return read_word(part, bit_words); }));
    }
    return false;
  }
  if (key == "processing") {
    return done(read_list(text, out.processing, durations(picoseconds(out.timing.ack_max_ps))));
  }
  if (key == "positions") return done(read_list(text, out.positions, read_position));
  if (key == "flags") {
    return done(read_list(text, out.flags, [](auto part) { return read_word(part, flag_words); }));
  }
  if (key == "faults") {
    return done(
        read_list(text, out.faults, [](auto part) { return read_word(part, fault_words); }));
  }
  if (key == "registers") return done(read_registers(text, out.registers));
  return false;
}

// Checks values that depend on several settings.
Checked check(const Settings& settings) {
  const auto channels = settings.format.channels();
  for (const auto& [name, fault] : fault_words) {
    const bool damages = cause_of(fault, settings.format.cds0) == BISS_CAUSE_CRC;
    if (!damages || has_crcs(settings.format)) continue;
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
  switch (fault) {
    case Fault::none:
      return BISS_CAUSE_OK;
    case Fault::flip:
    case Fault::flip_crc:
    case Fault::burst:
    case Fault::crc_polarity:
      return BISS_CAUSE_CRC;
    case Fault::no_answer:
      return BISS_CAUSE_NO_RESPONSE;
    case Fault::early_ack:
      return BISS_CAUSE_RESPONSE_RANGE;
    case Fault::slo_low:
      return BISS_CAUSE_NO_START;
    case Fault::cds_high:
      return cds0 ? BISS_CAUSE_CDS : BISS_CAUSE_OK;
    case Fault::stop_high:
      return BISS_CAUSE_STOP_BIT;
  }
  return BISS_CAUSE_OK;
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
  const auto format = pairs.find("format");
  if (format == pairs.end()) return Failed("format is missing");
  Settings settings;
  if (auto read = read_format(format->second, settings); !read) {
    return Failed(fmt::format("format: {}", read.error()));
  }
  for (const auto& [key, value] : pairs) {
    const auto read = read_setting(role, key, value, settings);
    if (!read) return Failed(fmt::format("{}: {}", key, read.error()));
    if (!*read) return Failed(fmt::format("no setting '{}'", key));
  }
  if (auto checked = check(settings); !checked) return Failed(checked.error());
  return settings;
}

}  // namespace biss::simulators
