#include "verbs/decode/motion_options.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "verbs/common/verb.hpp"

namespace biss::verbs {

namespace {

constexpr double turn_degrees = 360.0;
constexpr double nanometres_per_millimetre = 1e6;

rows::Scale per_turn(double counts) { return {.per_count = turn_degrees / counts, .unit = "deg"}; }

// Takes a number from the front.
std::optional<double> take_number(std::string_view& text) {
  double value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc() || !std::isfinite(value) || value <= 0) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(read.ptr - text.data()));
  return value;
}

// The counts of a turn, `67108864/turn` or `2^26/turn`, or a length such as `50nm`.
std::optional<rows::Scale> scale_in(std::string_view text) {
  constexpr unsigned most_bits = 63;
  constexpr std::array<std::pair<std::string_view, double>, 3> lengths{
      {{"nm", 1.0}, {"um", 1e3}, {"mm", nanometres_per_millimetre}}};
  const bool is_power = text.starts_with("2^");
  if (is_power) text.remove_prefix(2);
  const auto value = take_number(text);
  if (!value) return std::nullopt;
  if (text == "/turn") {
    if (*value != std::floor(*value) || (is_power && *value > most_bits)) return std::nullopt;
    return per_turn(is_power ? std::exp2(*value) : *value);
  }
  while (text.starts_with(' ')) text.remove_prefix(1);
  for (const auto& [unit, nanometres] : lengths) {
    if (is_power || text != unit) continue;
    return rows::Scale{.per_count = *value * nanometres / nanometres_per_millimetre, .unit = "mm"};
  }
  return std::nullopt;
}

}  // namespace

std::optional<rows::Scale> scale_of(const CatalogueEntry& entry) {
  std::string_view text = entry.resolution;
  // Which of them is right depends on the type of the encoder.
  if (text.find(" or ") != std::string_view::npos) return std::nullopt;
  text = text.substr(0, text.find(','));
  // For two channels, the first one counts.
  text = text.substr(0, text.find(" and "));
  if (!text.ends_with(" a turn")) return scale_in(text);
  text.remove_suffix(std::string_view(" a turn").size());
  return scale_in(std::string(text) + "/turn");
}

namespace {

// The unit of a value of --scale: `deg`, `mm`, `N/turn`, `2^N/turn`, or a length such as `50nm`.
// Empty for any other text.
std::optional<std::string> scale_unit(std::string_view text) {
  if (text == "deg" || text == "mm") return std::string(text);
  const auto scale = scale_in(text);
  return scale ? std::optional(scale->unit) : std::nullopt;
}

// The scale for a value of --scale. `deg` takes the counts of a turn from the singleturn bits of the
// format or from the catalogue, `mm` takes the size of a count from the catalogue.
tl::expected<rows::Scale, std::string> choose_scale(std::string_view text,
                                                    const ChannelFormat& channel,
                                                    const CatalogueEntry* entry) {
  if (const auto given = scale_in(text)) return *given;
  const auto known = entry != nullptr ? scale_of(*entry) : std::nullopt;
  if (known && known->unit == text) return *known;
  if (text == "deg" && channel.singleturn.present()) {
    return per_turn(std::exp2(unsigned{channel.singleturn.bits}));
  }
  if (text == "deg") {
    return tl::unexpected(
        std::string("--scale deg: the counts of a turn are not known for this format; give them, "
                    "such as --scale 2^26/turn, or -f with the name of a rotary encoder"));
  }
  return tl::unexpected(
      std::string("--scale mm: the size of a count is not known for this format; give it, such as "
                  "--scale 50nm, or -f with the name of a linear encoder"));
}

}  // namespace

rows::MotionColumns MotionArguments::columns() const {
  return {.unwrap = unwrap, .unit = scale_unit(scale).value_or(""), .velocity = velocity};
}

std::string MotionArguments::wrong_usage() const {
  return max_step && !unwrap && !velocity ? "--max-step: only with --unwrap or --velocity" : "";
}

void add_motion_options(Verb verb, MotionArguments& arguments) {
  verb = verb.scope(Scope::rows);
  verb.add_flag(
      "--unwrap", arguments.unwrap,
      "Add the column unwrapped: the position of channel 1, continued when it rolls over, "
      "with a sign");
  add_count_option(
      verb, "--max-step",
      [&arguments](std::uint64_t count) {
        if (count == 0) wrong_value("--max-step", "'0' is not 1 or more");
        arguments.max_step = count;
      },
      "Largest step in counts from one request to the next, below half of the range; by default a "
      "32nd of the range");
  verb.add_text_option(
          "--scale",
          [&arguments](const std::string& text) {
            if (!scale_unit(text)) {
              wrong_value("--scale",
                          fmt::format("'{}' is none of deg, mm, the counts of a turn such "
                                      "as 2^26/turn, the size of a count such as 50nm",
                                      text));
            }
            arguments.scale = text;
          },
          "Add the column position_deg or position_mm; deg and mm need a format with a "
          "known size of a count")
      .type_name("deg|mm|N/turn|LENGTH");
  verb.add_flag(
      "--velocity", arguments.velocity,
      "Add the column velocity_UNIT_s: mean velocity since the position before, in counts "
      "or the unit of --scale, per second");
}

tl::expected<rows::Motion, std::string> make_motion(const MotionArguments& arguments,
                                                    const ChannelFormat& channel,
                                                    const CatalogueEntry* entry) {
  const unsigned bits = channel.position_bits();
  if (bits == 0) {
    return tl::unexpected(
        std::string("--unwrap, --scale and --velocity: channel 1 of the format has no position"));
  }
  if (arguments.max_step.value_or(0) > TurnCounter::widest_step(bits)) {
    return tl::unexpected(
        fmt::format("--max-step: {} is not below half of the range of {} bits; the direction of "
                    "this step is not known",
                    *arguments.max_step, bits));
  }
  std::optional<rows::Scale> scale;
  if (!arguments.scale.empty()) {
    auto chosen = choose_scale(arguments.scale, channel, entry);
    if (!chosen) return tl::unexpected(chosen.error());
    scale = std::move(*chosen);
  }
  return rows::Motion(bits, arguments.max_step, arguments.unwrap, std::move(scale));
}

}  // namespace biss::verbs
