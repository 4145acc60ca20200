#include "verbs/common/configured.hpp"

#include <fmt/format.h>

#include "biss/control/register_map.hpp"
#include "biss/frame/format_text.hpp"
#include "device/device_text.hpp"
#include "device/quantity.hpp"
#include "verbs/eds/rows.hpp"

namespace biss::verbs {

namespace {

// "4D484D234400 (MHM#D)": the number, and its bytes as characters up to the first other byte.
std::string device_text(std::uint64_t device) {
  std::string letters;
  for (unsigned shift = 48; shift != 0;) {
    shift -= 8;
    const auto c = static_cast<char>(device >> shift & 0xFFU);
    if (c < 0x21 || c > 0x7E) break;
    letters += c;
  }
  const std::string number = fmt::format("{:012X}", device);
  return letters.empty() ? number : fmt::format("{} ({})", number, letters);
}

std::string maker_text(std::uint16_t id) {
  const auto name = manufacturer_name(id);
  return name ? fmt::format("0x{:04X} ({})", id, *name) : fmt::format("0x{:04X}", id);
}

std::string sheet_text(const SlaveDescription& slave) {
  if (slave.source == ValueSource::eds) return "read";
  if (slave.eds_unused) return fmt::format("in bank {}, not readable or wrong", slave.eds_bank);
  return "none";
}

void add_slave(report::Summary& out, std::size_t id, const SlaveDescription& slave) {
  const std::string key = fmt::format("ID {}", id);
  if (slave.identity) {
    out.entry(key, fmt::format("device {}", device_text(slave.identity->device)),
              fmt::format("maker {}", maker_text(slave.identity->manufacturer)));
  } else {
    out.entry(key, "no identity");
  }
  const std::string profile = slave.profile.value_or(0) != 0
                                  ? fmt::format("profile 0x{:04X}", *slave.profile)
                                  : "no profile identifier";
  const std::string serial = slave.serial ? fmt::format("serial number {}, ", *slave.serial) : "";
  out.entry("", profile, fmt::format("{}data sheet {}", serial, sheet_text(slave)));
}

void add_found(report::Summary& out, const Configuration& found) {
  for (std::size_t id = 0; id < found.slave_count; ++id) add_slave(out, id, found.slave_list[id]);
  const DeviceTiming& timing = found.timing;
  out.entry("format", format_text(found.format).view(), name_of(found.format_source));
  out.entry("clock", fmt::format("{} to {}", text_of(timing.clock_min), text_of(timing.clock_max)),
            name_of(found.clock_source));
  out.entry(
      "ACK",
      fmt::format("at most {} and {} clocks", text_of(timing.ack_max), found.start_delay_clocks),
      name_of(found.busy_source));
  out.entry("timeout", text_of(timing.timeout), name_of(found.timeout_source));
  out.entry("shortest cycle", timing.cycle_min.count == 0 ? "not given" : text_of(timing.cycle_min),
            name_of(found.cycle_source));
}

}  // namespace

bool asks_one(ConfigureStep step) {
  return step >= ConfigureStep::identity && step <= ConfigureStep::restore_bank;
}

std::string fault_text(const ConfigureFault& fault) {
  std::string text = fmt::format("{} at {}", name_of(fault.cause), name_of(fault.step));
  if (asks_one(fault.step)) text += fmt::format(" of ID {}", fault.slave);
  if (fault.control) text += fmt::format(": {}", name_of(*fault.control));
  if (fault.profile) text += fmt::format(": {}", text_of(*fault.profile));
  if (!fault.field.empty()) {
    text += fmt::format(
        ": {}: {}", fault.field,
        fault.problem ? text_of(*fault.problem) : "does not fit the slaves on the line");
  }
  if (fault.eds) text += fmt::format(": {}", text_of(*fault.eds));
  return text;
}

EdsFindingTaker lines_of_findings(std::vector<std::string>& lines) {
  return {[](void* list, std::uint8_t slave, const EdsFinding& finding) {
            static_cast<std::vector<std::string>*>(list)->push_back(
                fmt::format("ID {}: {}", slave, finding_line(finding_row(finding))));
          },
          &lines};
}

void add_configuration(report::Summary& out, const Result<Configuration, ConfigureFault>& found,
                       const std::vector<std::string>& findings) {
  if (found.ok()) add_found(out, *found);
  for (const std::string& finding : findings) {
    out.entry(&finding == findings.data() ? "data sheet" : "", finding);
  }
}

}  // namespace biss::verbs
