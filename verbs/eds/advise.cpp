// biss eds advise: the frame that fits a new encoder.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "biss/eds/advise.hpp"
#include "biss/eds/device.hpp"
#include "biss/eds/profile.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/timing/cable.hpp"
#include "report/summary.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/common/format_option.hpp"
#include "verbs/eds/description.hpp"
#include "verbs/eds/rows.hpp"
#include "verbs/eds/source.hpp"

namespace biss::verbs {
namespace {

struct AdviseOptions {
  EdsArguments arguments;
  FormatArguments timing;
  std::optional<unsigned> resolution;
  std::optional<unsigned> turns;
  unsigned resolution_field = 0;
  unsigned turns_field = 0;
  bool safety = false;
  std::optional<Hertz> rate;
  std::optional<Hertz> clock;
  std::optional<Millimetres> cable;
  std::string to = "table";
  std::string output;
};

const std::vector<std::string> advise_formats{"table", "jsonl", "description"};

// Resolution, turns and C from the first channel's BP3 part.
void take_part(const EdsSource& source, AdviceWish& wish) {
  const auto& part = source.sheet.profiles[0];
  if (!part || !part->whole) return;
  const Bp3Part bp3 = parse_bp3_part(part->filled);
  const Bp3Zeros turns = turns_zeros(bp3);
  const Bp3Zeros singleturn = bp3.linear() ? scale_zeros(bp3) : singleturn_zeros(bp3);
  wish.turns_field_bits = bp3.linear() ? 0 : bp3.mt_len;
  wish.turns_bits = wish.turns_field_bits - (bp3.linear() ? 0 : turns.leading + turns.trailing);
  wish.resolution_field_bits = bp3.position_bits() - wish.turns_field_bits;
  wish.resolution_bits = wish.resolution_field_bits - singleturn.leading - singleturn.trailing;
  const std::uint16_t registers = source.sheet.identifiers[0].value_or(0);
  const ProfileIdentifier identifier{registers != 0 ? registers : std::uint16_t{bp3.bp_id}};
  const bool has_c = identifier.profile() == Profile::bp3 || identifier.profile() == Profile::bp3s;
  wish.in_safety_encoder = has_c && identifier.crc_is_data();
}

void take_options(const AdviseOptions& options, AdviceWish& wish) {
  if (options.resolution) {
    wish.resolution_bits = *options.resolution;
    wish.resolution_field_bits = 0;
  }
  if (options.turns) {
    wish.turns_bits = *options.turns;
    wish.turns_field_bits = 0;
  }
  if (options.resolution_field != 0) wish.resolution_field_bits = options.resolution_field;
  if (options.turns_field != 0) wish.turns_field_bits = options.turns_field;
  wish.in_safety_encoder = wish.in_safety_encoder || options.safety;
  wish.rate = options.rate.value_or(Hertz{});
  wish.clock = options.clock.value_or(Hertz{});
  wish.timing = value_or_fail(override_timing(options.timing, wish.timing));
  if (options.cable) wish.line_delay = line_delay(*options.cable, wish.timing.internal_delay_max);
}

std::string alignment_text(unsigned zeros, const char* where, const char* otherwise) {
  return zeros == 0 ? otherwise : report::counted(zeros, "zero") + ' ' + where;
}

std::string summary_of(const AdviceWish& wish, const Advice& advice, const FrameFormat& format) {
  report::Summary out;
  const Hertz clock = wish.clock.count != 0 ? wish.clock : wish.timing.clock_max;
  out.entry("format", format_text(format).view());
  out.entry("data length", fmt::format("{} bits", advice.channel.data_bits),
            advice.identifier != 0 ? fmt::format("BP_ID 0x{:04X}", advice.identifier)
                                   : "too long for BP3, which allows 57");
  const CrcSpec& crc = advice.channel.crc;
  out.entry("CRC",
            fmt::format("0x{:X}, {} bits, as CPOLY 0x{:X}; up to {} wrong bits are always detected",
                        crc.polynomial, crc.width_bits, crc.polynomial >> 1U,
                        advice.hamming_distance - 1));
  if (wish.turns_bits != 0) {
    out.entry("turns", alignment_text(advice.leading_zeros, "before them", "fill their field"),
              "right-aligned, MT_FMT right");
  }
  if (wish.resolution_bits != 0) {
    out.entry("resolution", alignment_text(advice.trailing_zeros, "after it", "fills its field"),
              "left-aligned, FI_FMT left");
  }
  out.entry("cycle", fmt::format("{} at {}", text_of(advice.budget.total), text_of(clock)),
            fmt::format("at most {} requests per second", advice.budget.request_rate_max.count));
  if (wish.rate.count != 0) {
    out.entry(
        "rate",
        fmt::format("{} {}", text_of(wish.rate), advice.feasible ? "is feasible" : "is too fast"),
        advice.clock_needed.count != 0
            ? fmt::format("needs a clock of at least {}", text_of(advice.clock_needed))
            : "at any clock of this device");
  }
  return out.text();
}

bool write_object(const Advice& advice, const FrameFormat& format, Output& output) {
  return write_rows({{{"format", format_text(format).view()},
                      {"data_bits", advice.channel.data_bits},
                      {"bp_id", unless_0(advice.identifier)},
                      {"cpoly", advice.channel.crc.polynomial >> 1U},
                      {"min_distance", advice.hamming_distance},
                      {"leading_zeros", advice.leading_zeros},
                      {"trailing_zeros", advice.trailing_zeros},
                      {"cycle_ns", advice.budget.total},
                      {"rate_max_hz", advice.budget.request_rate_max},
                      {"feasible", advice.feasible},
                      {"clock_needed_hz", unless_0(advice.clock_needed.count)}}},
                    report::Format::jsonl, output);
}

// The BP3 part of the advised frame, to be completed and built.
std::string description_of(const Advice& advice) {
  dump::DataSheet sheet;
  dump::FoundPart& part = sheet.profiles[0].emplace();
  part.whole = true;
  part.filled = bp3_bank_of(advice);
  for (std::size_t i = 0; i < bank_bytes; ++i) part.bytes[i] = part.filled[i];
  std::string text = write_description({}, sheet);
  // Left out, so that `build` derives it from the completed part.
  const std::size_t checksum = text.find("CHKSUM");
  if (checksum != std::string::npos) text.erase(checksum);
  return text;
}

// No lengths, neither in the options nor in the file.
std::string nothing_to_advise(const std::string& file) {
  if (file.empty()) {
    return "give the lengths that the encoder sends, --resolution and --turns in bits, or a FILE "
           "with its BP3 "
           "part; for example: biss eds advise --resolution 18 --turns 12";
  }
  return fmt::format(
      "'{}' has no BP3 part of data channel 0 with lengths; give --resolution or --turns", file);
}

ExitStatus run_advise(const AdviseOptions& options, Host& host) {
  AdviceWish wish;
  if (!options.arguments.file.empty()) {
    const EdsSource source = load_eds_with_part(options.arguments, host);
    for (const EdsFindingRow& row : eds_findings(source.sheet)) {
      host.warn(fmt::format("{}: {}", part_text(row.part, row.channel), finding_line(row)));
    }
    const auto ignore = [](const EdsRemark&) {};
    const auto device = describe_device(source.stored.image(), source.overrides, ignore);
    if (device.ok()) {
      wish.timing = timing_at(*device, options.clock.value_or(device->timing.clock_max));
    }
    take_part(source, wish);
  }
  take_options(options, wish);
  if (wish.resolution_bits == 0 && wish.turns_bits == 0) {
    fail_if(nothing_to_advise(options.arguments.file));
  }
  const auto advice = advise(wish);
  if (!advice.ok()) return host.fail(ExitStatus::usage, text_of(advice.error()));
  if (options.to == "description" && advice->identifier == 0) {
    return host.fail(ExitStatus::data_failed,
                     "the position is too long for BP3, so there is no part to write");
  }
  FrameFormat format;
  format.channel_count = 1;
  format.channel_list[0] = advice->channel;
  const ExitStatus written = write_output(host, options.output, [&](Output& output) {
    return options.to == "table"   ? output.write(summary_of(wish, *advice, format))
           : options.to == "jsonl" ? write_object(*advice, format, output)
                                   : output.write(description_of(*advice));
  });
  return advice->feasible ? written : std::max(written, ExitStatus::data_failed);
}

}  // namespace

Run add_eds_advise(Verb verb) {
  const auto options = std::make_shared<AdviseOptions>();
  add_eds_file(verb, options->arguments.file, false);
  const auto bits = [&verb](const char* name, auto& target, const char* what) {
    add_count_option(verb, name, into(target), what, 64).type_name("BITS");
  };
  bits("--resolution", options->resolution, "Bits of the position within a turn or along a scale");
  bits("--turns", options->turns, "Bits of the number of turns");
  bits("--resolution-field", options->resolution_field, "Width of the field of the resolution");
  bits("--turns-field", options->turns_field, "Width of the field of the turns");
  verb.add_flag("--safety", options->safety,
                "Word of a safety encoder: C = 1, its CRC counts as data");
  add_rate_option(verb, "--rate", into(options->rate), "Required requests per second");
  add_rate_option(verb, "--clock", into(options->clock),
                  "Frequency of MA; by default the highest of the encoder");
  add_length_option(verb, "--cable", into(options->cable), "Cable length from master to encoder");
  add_timing_options(verb, options->timing);
  add_eds_options(verb, options->arguments);
  add_name_option(verb, "--to", options->to, advise_formats,
                  "Output format; by default from the ending of -o, else table");
  let_output_choose(verb, advise_formats, into(options->to));
  add_output_option(verb, options->output);
  return [options](Host& host) { return run_advise(*options, host); };
}

}  // namespace biss::verbs
