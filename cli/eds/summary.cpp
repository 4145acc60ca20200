#include "cli/eds/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "biss/eds/device.hpp"
#include "biss/frame/format_text.hpp"
#include "cli/common/format_option.hpp"
#include "cli/common/quantity.hpp"
#include "cli/eds/value.hpp"
#include "report/summary.hpp"

namespace biss::cli {
namespace {

// Three things are said of every data sheet whose times are used; once is enough for all fields.
struct Gathered {
  std::string hypotheses;
  std::string missing;
};

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
  return fmt::format("BP_ID: {}", doubt_of({static_cast<std::uint16_t>(remark.used)}));
}

void gather(std::string& list, std::string_view symbol) {
  if (!list.empty()) list += ", ";
  list += symbol;
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

}  // namespace

std::string eds_summary(const EdsSource& source) {
  std::vector<std::string> lines;
  Gathered gathered;
  const auto take = [&](const EdsRemark& remark) {
    if (remark.kind == EdsRemarkKind::hypothesis) return gather(gathered.hypotheses, remark.symbol);
    if (remark.kind == EdsRemarkKind::not_given) return gather(gathered.missing, remark.symbol);
    lines.push_back(remark.kind == EdsRemarkKind::doubtful ? text_of_doubt(remark)
                                                           : remark_line(remark));
  };
  const EdsImage image = source.stored.image();
  const auto device = describe_device(image, source.overrides, take);
  report::Summary out;
  if (device.ok()) {
    add_device(out, *device);
  } else {
    out.entry("format", fmt::format("none: {}", text_of(device.error().cause)));
  }
  if (!gathered.hypotheses.empty()) {
    lines.push_back(gathered.hypotheses + ": no source confirms the unit (?)");
  }
  if (!gathered.missing.empty()) {
    lines.push_back(gathered.missing + ": not given, the widest that BiSS C allows");
  }
  std::string_view key = "not certain";
  for (const std::string& line : lines) {
    out.entry(key, line);
    key = "";
  }
  return "\n" + out.text();
}

}  // namespace biss::cli
