#include "cli/common/decoded_capture.hpp"

#include <fmt/format.h>

#include "cli/common/message.hpp"
#include "decode/decoder.hpp"
#include "decode/polarity.hpp"
#include "decode/statistics.hpp"

namespace biss::cli {

namespace {

// `FILE` of `FILE:NAME`.
std::string file_of_line(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  return colon == std::string::npos ? std::string() : text.substr(0, colon);
}

bool is_resolution(Picoseconds time) { return time >= Picoseconds{} && time <= milliseconds(1); }

}  // namespace

void add_capture_options(Verb verb, CaptureArguments& arguments) {
  verb.add_option(
          "FILE", arguments.files,
          "Captures (VCD, event CSV, .sr, Saleae CSV, raw samples); several are read as one; - is "
          "standard input")
      .file(FileUse::read);
  add_format_option(verb, arguments.device, false, "; none: check the structure alone");
  add_timing_options(verb, arguments.device);
  verb.add_option("--ma", arguments.ma, "The line that is MA")
      .type_name("NAME|FILE:NAME")
      .file(FileUse::read, file_of_line);
  verb.add_option("--slo", arguments.slo, "The line that is SLO")
      .type_name("NAME|FILE:NAME")
      .file(FileUse::read, file_of_line);
  verb.add_flag("--invert-ma", arguments.invert_ma,
                "The capture shows MA inverted; measured by default");
  verb.add_flag("--invert-slo", arguments.invert_slo,
                "The capture shows SLO inverted; measured by default");
  add_duration_option(verb, "--resolution", into(arguments.resolution),
                      "Edge timing uncertainty of the capture: its sample period where the file "
                      "gives it, else 0");
  add_raw_options(verb, arguments.raw);
}

ExitStatus DecodedCapture::open(const CaptureArguments& arguments,
                                const std::vector<std::string>& outputs,
                                const MarginArguments& margin) {
  if (arguments.device.format.empty() || arguments.device.format == "none") {
    const std::string wrong = override_timing(arguments.device, timing_);
    if (!wrong.empty()) return fail(ExitStatus::usage, wrong);
  } else {
    const DeviceChoice choice = choose_device(arguments.device);
    if (!choice) return fail(ExitStatus::usage, choice.error);
    format_ = choice.device->format;
    timing_ = choice.device->timing;
  }
  const auto opened = input_.open(arguments.files, arguments.ma, arguments.slo, arguments.raw);
  if (opened != ExitStatus::done) return opened;
  if (arguments.resolution && !is_resolution(*arguments.resolution)) {
    return fail(ExitStatus::usage, "--resolution: from 0s to 1ms");
  }
  for (const std::string& output : outputs) {
    if (input_.reads(output)) {
      return fail(ExitStatus::usage,
                  fmt::format("-o {}: is the capture itself; name another file", output));
    }
  }
  margin_ = {.compensated = !margin.no_compensation,
             .resolution = arguments.resolution.value_or(input_.sample_period())};
  lines_ = find_capture_lines(input_, arguments.ma, arguments.slo, reader());
  if (lines_.status != ExitStatus::done) return fail(lines_.status, lines_.problem);
  decode::FoundLines& found = lines_.found;
  found.lines.ma_inverted = arguments.invert_ma;
  found.lines.slo_inverted = arguments.invert_slo;
  found.lines = decode::find_polarity(found.lines, lines_.beginning, reader());
  found.look_swapped = found.look_swapped && !found.lines.slo_inverted;
  return ExitStatus::done;
}

Picoseconds DecodedCapture::interval() const {
  decode::Statistics first;
  decode::Decoder decoder(reader(), [&](const decode::Cycle& cycle) { first.add(cycle); });
  decoder.push(lines_.beginning, lines().lines);
  const decode::Distribution& interval = first.interval();
  return interval.count() == 0 ? Picoseconds{} : picoseconds(interval.median());
}

bool DecodedCapture::read(const OnCycle& on_cycle) {
  std::uint64_t number = 0;
  bool wanted = true;
  decode::Decoder decoder(
      reader(), [&](const decode::Cycle& cycle) { wanted = wanted && on_cycle(number++, cycle); });
  for (auto block = input_.next(); !block.empty() && wanted; block = input_.next()) {
    decoder.push(block, lines().lines);
  }
  decoder.finish(input_.end_time());
  return input_.error().empty();
}

ExitStatus DecodedCapture::no_request() const {
  return fail(ExitStatus::data_failed,
              fmt::format("{}: no request cycle found on MA ({}); is it the right line, is the "
                          "time unit right, and did the master ask?",
                          input_.name(), input_.lines()[lines().lines.ma]));
}

}  // namespace biss::cli
