#include "verbs/decode/motion_options.hpp"

#include <fmt/format.h>

#include "verbs/common/verb.hpp"
#include "verbs/decode/scale.hpp"

namespace biss::verbs {

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
