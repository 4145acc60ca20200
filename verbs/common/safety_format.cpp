#include "verbs/common/safety_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>

#include "biss/frame/format_text.hpp"
#include "verbs/common/format_option.hpp"
#include "verbs/common/text_file.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/safety/setup_fields.hpp"

namespace biss::verbs {
namespace {

using Json = nlohmann::ordered_json;

// Formats have no dot and no slash.
bool names_a_file(std::string_view text) {
  return text.ends_with(".json") || text.find('/') != std::string_view::npos;
}

// Numbers, flags and times in picoseconds as numbers, choices by name.
struct WriteFields {
  Json& json;

  template <class Number>
  void number(SetupField field, const Number& value) const {
    json[field.group][field.name] = value;
  }
  void time(SetupField field, const Picoseconds& value) const { number(field, value.count); }
  template <class Choice>
  void choice(SetupField field, const Choice& value,
              std::span<const std::string_view> names) const {
    json[field.group][field.name] = names[static_cast<std::size_t>(value)];
  }
};

// Throws what nlohmann throws, or std::out_of_range.
struct ReadFields {
  const Json& json;

  const Json& at(SetupField field) const { return json.at(field.group).at(field.name); }
  void number(SetupField field, bool& value) const { at(field).get_to(value); }
  template <class Number>
  void number(SetupField field, Number& value) const {
    const std::uint64_t read = at(field).template get_ref<const Json::number_unsigned_t&>();
    if (read > static_cast<std::uint64_t>(std::numeric_limits<Number>::max())) {
      throw std::out_of_range(field.name);
    }
    value = static_cast<Number>(read);
  }
  void time(SetupField field, Picoseconds& value) const { number(field, value.count); }
  template <class Choice>
  void choice(SetupField field, Choice& value, std::span<const std::string_view> names) const {
    const auto found = std::find(names.begin(), names.end(), at(field).get<std::string>());
    if (found == names.end()) throw std::out_of_range(field.name);
    value = static_cast<Choice>(found - names.begin());
  }
};

safety_detail::Alignment alignment_of(const SafetyFormat& monitored) {
  return safety_detail::alignment_of(monitored.cpw(), monitored.spw(), monitored.setup.comparison);
}

}  // namespace

SafetyFormat::UncheckedBits SafetyFormat::unchecked_bits() const {
  const auto alignment = alignment_of(*this);
  const unsigned cpw_bits = safety_detail::singleturn_bits(cpw());
  const unsigned both = std::min(cpw_bits, safety_detail::singleturn_bits(spw()));
  return {cpw_bits - both, both - alignment.singleturn_bits,
          cpw().multiturn.bits - (alignment.bits - alignment.singleturn_bits)};
}

const SafetyConfiguration* implied_configuration(std::string_view text, const FrameFormat& format) {
  if (const SafetyConfiguration* named = find_safety_configuration(text)) return named;
  FrameFormat plain = format;
  for (const SafetyConfiguration& each : safety_configurations) {
    const FrameFormat known = each.frame_format();
    plain.cds0 = known.cds0;
    if (plain == known) return &each;
  }
  return nullptr;
}

bool is_safety_format(const FrameFormat& format) {
  return format.channel_count == 2 && !check_safety(format, UnratedSafetySetup());
}

std::optional<SafetyFormat> parse_safety_format(std::string_view text) {
  if (const SafetyConfiguration* known = find_safety_configuration(text)) {
    return SafetyFormat{known->frame_format(), known->setup, std::string(text)};
  }
  if (names_a_file(text)) {
    const auto file = read_text_file(std::string(text));
    return file ? parse_configuration_json(*file) : std::nullopt;
  }
  const auto choice = parse_device(text);
  if (!choice || !is_safety_format(choice->format)) return std::nullopt;
  SafetyFormat found{choice->format, {}, std::string(text)};
  if (choice->entry != nullptr) {
    const SafetyConfiguration* implied = implied_configuration(text, found.format);
    if (implied != nullptr) found.setup = implied->setup;
  }
  return found;
}

std::string safety_format_error(std::string_view text) {
  if (names_a_file(text)) {
    const auto file = read_text_file(std::string(text));
    return fmt::format(
        "'{}': {}", text,
        file ? "it is not configuration.json of an evidence bundle, or its setup is refused"
             : file.error());
  }
  const auto choice = parse_device(text);
  if (!choice) return choice.error();
  return fmt::format(
      "'{}' is neither a safety configuration such as fs-36-28 nor the format of a control and a "
      "safety word that can be monitored",
      text);
}

Option& add_safety_format_option(Verb verb, std::string& target) {
  return verb
      .add_option("-f,--format", target,
                  "Safety configuration, catalogue name, format of a control and a safety "
                  "word, or configuration.json of an evidence bundle")
      .file(FileUse::read,
            [](const std::string& text) { return names_a_file(text) ? text : std::string(); });
}

Hertz rate_of_cycle(const SafetySetup& setup) {
  return Hertz{static_cast<std::uint32_t>(picoseconds_per_second / setup.cycle_min.count)};
}

std::string configuration_json(const SafetyFormat& monitored, std::string_view name) {
  const auto alignment = alignment_of(monitored);
  const SafetyFormat::UncheckedBits unchecked = monitored.unchecked_bits();
  const auto* known = find_safety_configuration(name);
  Json setup;
  SafetySetup fields = monitored.setup;
  for_each_field(fields, WriteFields{setup});
  const Json json = {{"configuration", name},
                     {"source", known != nullptr ? Json(known->source) : Json()},
                     {"resolution", known != nullptr ? Json(known->resolution) : Json()},
                     {"device", monitored.device},
                     {"format", format_text(monitored.format).view()},
                     {"setup", setup},
                     {"compared_bits", alignment.bits},
                     {"compared_turns_bits", alignment.bits - alignment.singleturn_bits},
                     {"cpw_bits_not_compared",
                      {{"below_spw_resolution", unchecked.below_resolution},
                       {"by_compare_bits", unchecked.not_compared},
                       {"turns", unchecked.turns}}},
                     {"counter_period_frames", counter_period(monitored.setup.counter.mode)}};
  return json.dump(2) + "\n";
}

std::optional<SafetyFormat> parse_configuration_json(const std::string& text) try {
  const Json json = Json::parse(text);
  SafetyFormat found;
  const auto format = parse_format(json.at("format").get<std::string>());
  if (!format.ok() || format->channel_count != 2) return std::nullopt;
  found.format = *format;
  json.at("device").get_to(found.device);
  for_each_field(found.setup, ReadFields{json.at("setup")});
  if (check_safety(found.format, UnratedSafetySetup(found.setup))) return std::nullopt;
  return found;
} catch (const std::exception&) {
  return std::nullopt;
}

}  // namespace biss::verbs
