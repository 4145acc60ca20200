// biss eds show: the fields of a data sheet, and the frame that it describes.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "biss/eds/device.hpp"
#include "biss/eds/image.hpp"
#include "biss/frame/format_text.hpp"
#include "report/summary.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/common/format_option.hpp"
#include "verbs/eds/description.hpp"
#include "verbs/eds/rows.hpp"
#include "verbs/eds/source.hpp"

namespace biss::verbs {
namespace {

struct ShowOptions {
  EdsArguments arguments;
  std::string to = "table";
  bool all = false;
  std::string output;
};

const std::vector<std::string> show_formats{"table", "csv", "jsonl", "description"};

bool write_table(const EdsSource& source, const ShowOptions& options, Output& output) {
  std::vector<EdsFieldRow> shown = eds_fields(source.sheet);
  std::erase_if(shown, [&](const EdsFieldRow& field) {
    return field.unused && field.value.value_or(0) == 0 && !options.all;
  });
  return write_rows(shown, report::Format::table, output, [](const EdsFieldRow& field) {
    return FieldRow{{"part", part_text(field.part, field.channel)},
                    {"address", fmt::format("0x{:02X}", field.address)},
                    {"symbol", field.symbol},
                    {"stored", field.value},
                    {"means", unless_empty(field.means)},
                    {"what", field.meaning}};
  });
}

FieldRow csv_fields(const EdsFieldRow& field) {
  return {{"part", field.part},       {"channel", field.channel}, {"bank", field.bank},
          {"address", field.address}, {"symbol", field.symbol},   {"value", field.value},
          {"means", field.means}};
}

// One object per part: the documents' symbols, then which part it is.
bool write_object(const EdsPartRow& part, Output& output) {
  FieldRow row{{"part", name_of(part.part)}};
  for (const EdsField& field : fields_of(part.part)) {
    if (field.kind == EdsKind::reserved || field.kind == EdsKind::unnamed) continue;
    row.emplace_back(std::string(field.symbol), known_value(*part.found, field));
  }
  row.emplace_back("channel", part.channel);
  row.emplace_back("bank", part.found->bank);
  std::string bytes;
  for (const auto& byte : part.found->bytes) {
    bytes += byte ? fmt::format("{:02X}", *byte) : std::string("--");
  }
  row.emplace_back("bytes", bytes);
  return write_rows({row}, report::Format::jsonl, output);
}

dump::RegisterDump overridden_dump(const EdsSource& source) {
  dump::RegisterDump dump = source.dump;
  if (source.overrides.empty()) return dump;
  for (const EdsPartRow& part : eds_parts(source.sheet)) {
    if (part.found->whole) dump.set_bank(part.found->bank, part.found->filled);
  }
  return dump;
}

bool write_source(const EdsSource& source, const ShowOptions& options, Output& output) {
  if (options.to == "table") return write_table(source, options, output);
  if (options.to == "csv") {
    return write_rows(eds_fields(source.sheet), report::Format::csv, output, csv_fields);
  }
  if (options.to == "description") {
    return output.write(write_description(overridden_dump(source), source.sheet));
  }
  const auto parts = eds_parts(source.sheet);
  return std::all_of(parts.begin(), parts.end(),
                     [&](const EdsPartRow& part) { return write_object(part, output); });
}

std::string remark_line(const EdsRemark& remark) {
  const std::string where =
      remark.part == EdsPart::common ? "" : fmt::format(" of channel {}", remark.channel);
  std::string out = fmt::format("{}{}: {}", remark.symbol, where, text_of(remark.kind));
  const bool both = remark.kind == EdsRemarkKind::overridden ||
                    remark.kind == EdsRemarkKind::disagrees ||
                    remark.kind == EdsRemarkKind::repaired;
  if (both) out += fmt::format(" ({} stored, {} used)", remark.stored, remark.used);
  return out;
}

std::string text_of_doubt(const EdsRemark& remark) {
  const std::string where =
      remark.channel == 0 ? "" : fmt::format(" of channel {}", remark.channel);
  return fmt::format("BP_ID{}: {}", where, doubt_of({static_cast<std::uint16_t>(remark.used)}));
}

void add_device(report::Summary& out, const EdsDevice& device) {
  out.entry("format", format_text(device.format).view());
  out.entry("clock", fmt::format("at most {}", text_of(device.timing.clock_max)));
  std::string ack = fmt::format("at most {}", text_of(device.timing.ack_max));
  if (device.busy_s_clocks != 0) ack += fmt::format(" and {} clocks", device.busy_s_clocks);
  out.entry("ACK", ack);
  out.entry("timeout", text_of(device.timing.timeout));
  if (device.timing.cycle_min.count != 0) {
    out.entry("shortest cycle", text_of(device.timing.cycle_min));
  }
  if (device.control_ready) {
    out.entry("registers", fmt::format("{} after power-on", text_of(*device.control_ready)));
  }
  if (device.position_ready) {
    out.entry("positions", fmt::format("{} after power-on", text_of(*device.position_ready)));
  }
}

// Frame format, timing, and everything doubtful about them.
std::string eds_summary(const EdsSource& source) {
  std::vector<std::string> lines;
  // Remarks that concern many fields: one line each for all symbols.
  std::vector<std::string_view> hypotheses;
  std::vector<std::string_view> missing;
  const auto take = [&](const EdsRemark& remark) {
    if (remark.kind == EdsRemarkKind::hypothesis) return hypotheses.push_back(remark.symbol);
    const bool is_time = remark.part == EdsPart::common && find_scale(remark.symbol) != nullptr;
    if (remark.kind == EdsRemarkKind::not_given && is_time) return missing.push_back(remark.symbol);
    lines.push_back(remark.kind == EdsRemarkKind::doubtful ? text_of_doubt(remark)
                                                           : remark_line(remark));
  };
  const EdsImage image = source.stored.image();
  const auto device = describe_device(image, source.overrides, take);
  check_eds(source.sheet.image(), [&](const EdsFinding& finding) {
    if (contradicts(finding)) lines.push_back(finding_line(finding_row(finding)));
  });
  report::Summary out;
  if (device.ok()) {
    add_device(out, *device);
  } else {
    out.entry("format", fmt::format("none: {}", text_of(device.error().cause)));
  }
  if (!hypotheses.empty()) {
    lines.push_back(
        fmt::format("{}: no source confirms the unit (?)", fmt::join(hypotheses, ", ")));
  }
  if (!missing.empty()) {
    lines.push_back(
        fmt::format("{}: not given, the widest that BiSS C allows", fmt::join(missing, ", ")));
  }
  std::string_view key = "not certain";
  for (const std::string& line : lines) {
    out.entry(key, line);
    key = "";
  }
  return "\n" + out.text();
}

ExitStatus run_show(const ShowOptions& options, Host& host) {
  const bool description = options.to == "description";
  // A description also holds the registers of a device without data sheet.
  const EdsSource source =
      description ? load_eds(options.arguments, host) : load_eds_with_part(options.arguments, host);
  for (const EdsPartRow& part : eds_parts(source.sheet)) {
    if (part.found->whole) continue;
    host.warn(fmt::format("bank {} is incomplete: its {} part is shown, but not used",
                          part.found->bank, name_of(part.part)));
  }
  const ExitStatus written = write_output(
      host, options.output, [&](Output& output) { return write_source(source, options, output); });
  if (written == ExitStatus::done && options.to == "table") {
    host.print_summary(eds_summary(source));
  }
  return written;
}

}  // namespace

Run add_eds_show(Verb verb) {
  const auto options = std::make_shared<ShowOptions>();
  add_eds_file(verb, options->arguments.file);
  add_eds_options(verb, options->arguments);
  verb.add_flag("--all", options->all, "Also show reserved bytes and unused channels in the table");
  add_name_option(verb, "--to", options->to, show_formats,
                  "Output format; by default from the ending of -o, else table");
  let_output_choose(verb, show_formats, into(options->to));
  add_output_option(verb, options->output);
  return [options](Host& host) { return run_show(*options, host); };
}

}  // namespace biss::verbs
