#include "tools/decoded_capture.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "decode/lines.hpp"
#include "tools/message.hpp"

namespace biss::tools {

namespace {

constexpr std::size_t edges_to_find_lines = std::size_t{1} << 18U;

}  // namespace

void add_capture_options(CLI::App& verb, CaptureArguments& arguments) {
  verb.add_option(
      "FILE", arguments.files,
      "Captures (VCD, event CSV, .sr, Saleae CSV, raw samples); several are read as one; - is "
      "standard input");
  add_format_option(verb, arguments.device, false);
  add_timing_options(verb, arguments.device);
  verb.add_option("--ma", arguments.ma, "The line that is MA")->type_name("NAME|FILE:NAME");
  verb.add_option("--slo", arguments.slo, "The line that is SLO")->type_name("NAME|FILE:NAME");
  add_raw_options(verb, arguments.raw);
}

ExitStatus DecodedCapture::open(const CaptureArguments& arguments) {
  if (arguments.device.format.empty()) {
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
  const auto beginning = input_.look_at_beginning(edges_to_find_lines);
  const auto found =
      find_lines(input_.lines(), beginning, input_.line_of(arguments.ma),
                 input_.line_of(arguments.slo), decode::CycleReader(format_, timing_));
  if (found.ok()) {
    lines_ = found->lines;
    return ExitStatus::done;
  }
  if (!input_.error().empty()) return fail(ExitStatus::io, input_.error());
  const bool named = !arguments.ma.empty() || !arguments.slo.empty();
  return fail(named ? ExitStatus::usage : ExitStatus::data_failed,
              fmt::format("{}: MA and SLO not found; name them with --ma and --slo of {}",
                          input_.name(), fmt::join(input_.lines(), ", ")));
}

ExitStatus DecodedCapture::read(const OnCycle& on_cycle) {
  std::uint64_t number = 0;
  decode::Decoder decoder(decode::CycleReader(format_, timing_),
                          [&](const decode::Cycle& cycle) { on_cycle(number++, cycle); });
  for (auto block = input_.next(); !block.empty(); block = input_.next()) {
    decoder.push(block, lines_);
  }
  decoder.finish(input_.end_time());
  if (!input_.error().empty()) return fail(ExitStatus::io, input_.error());
  if (number != 0) return ExitStatus::done;
  return fail(ExitStatus::data_failed, fmt::format("{}: no request cycle found on MA ({})",
                                                   input_.name(), input_.lines()[lines_.ma]));
}

}  // namespace biss::tools
