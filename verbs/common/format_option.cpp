#include "verbs/common/format_option.hpp"

#include <fmt/format.h>

#include "verbs/common/verb.hpp"

namespace biss::verbs {

void add_format_option(Verb verb, FormatArguments& arguments, bool required,
                       const std::string& more) {
  verb.add_option("-f,--format", arguments.format,
                  "Frame format: items in line order (pos26,nE,nW,crc6), a name that 'biss "
                  "encoders' lists, or a profile identifier (bp3:0x621E)" +
                      more)
      .required(required)
      .type_name("FORMAT");
}

void add_timing_options(Verb verb, FormatArguments& arguments) {
  Verb section = verb.section("Device timing");
  const auto option = [&section](const char* name, std::string& value, const char* type,
                                 const char* help) {
    section.add_option(name, value, help).type_name(type);
  };
  option("--ack-max", arguments.ack_max, "TIME", "Longest ACK, as a time, for example 16us");
  option("--ack-clocks", arguments.ack_clocks, "N", "Fixed length of ACK in clocks");
  option("--timeout", arguments.timeout, "RULE",
         "Timeout rule: adaptive, static:20us or cycle:31.25us");
  option("--release", arguments.release, "N",
         "Half periods of MA for which SLO stays low after the last edge, if the frame is longer "
         "than the timeout cycle:...; 3 by default, which is assumed");
  option("--clock-max", arguments.clock_max, "RATE", "Highest clock of the device");
  option("--cycle-min", arguments.cycle_min, "TIME", "Shortest time from request to request");
}

std::string missing_field(const FrameFormat& format, FieldKind kind) {
  bool found = false;
  for (const ChannelFormat& channel : format.channels()) {
    for_each_field(channel, [&](const LineField& field) { found = found || field.kind == kind; });
  }
  if (found) return {};
  return kind == FieldKind::error     ? "the format has no error bit (nE or E)"
         : kind == FieldKind::warning ? "the format has no warning bit (nW or W)"
                                      : "the format has no counter (lcN)";
}

std::string wrong_slaves(std::uint64_t slaves, const FrameFormat& format) {
  if (slaves >= 1 && slaves <= format.channel_count) return {};
  return fmt::format(
      "--slaves '{}': 1 to {}, as many as the format has channels; join the formats of a chain by "
      "+, the format of the encoder next to the master first",
      slaves, format.channel_count);
}

}  // namespace biss::verbs
