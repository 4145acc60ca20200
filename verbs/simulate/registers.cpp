#include "verbs/simulate/registers.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "biss/eds/check.hpp"
#include "biss/eds/device.hpp"
#include "biss/eds/profile.hpp"
#include "biss/frame/format_text.hpp"
#include "device/quantity.hpp"
#include "verbs/eds/rows.hpp"
#include "verbs/eds/source.hpp"

namespace biss::verbs {

namespace {

bool is_map(unsigned address) { return register_field(address).access == FieldAccess::read_only; }

sim::EncoderRegisters registers_of(const dump::RegisterDump& dump, const dump::DataSheet& sheet) {
  sim::EncoderRegisters registers;
  for (unsigned number = 0; number < bank_count; ++number) {
    const auto is_here = [number](const auto& part) { return part && part->bank == number; };
    const bool fixed =
        is_here(sheet.common) || std::any_of(sheet.profiles.begin(), sheet.profiles.end(), is_here);
    const auto protection = fixed ? RegisterProtection::read_only : RegisterProtection::read_write;
    for (unsigned at = 0; at < bank_bytes; ++at) {
      const auto byte = dump.bank(number)[at];
      if (byte) registers.bank(number).put(at, {&*byte, 1}, protection);
    }
  }
  for (unsigned address = reg::eds_bank; address <= dump::last_address; ++address) {
    const auto byte = dump.direct_byte(address);
    if (!byte) continue;
    registers.put(address, *byte,
                  is_map(address) ? RegisterProtection::read_only : RegisterProtection::read_write);
  }
  const auto banks = dump.banks();
  const auto bsel = dump.direct_byte(reg::bsel);
  if (bsel || (banks && banks->last != 0)) registers.put_bsel(bsel.value_or(0));
  return registers;
}

// `ID:FILE`, ID one digit.
bool has_id(const std::string& argument) {
  return argument.size() > 2 && argument[1] == ':' && argument[0] >= '0' &&
         argument[0] < '0' + static_cast<int>(control_max_slaves);
}

// From the data sheet, else from the profile identifier.
FormatArguments device_of(const dump::RegisterDump& dump, const dump::DataSheet& sheet) {
  FormatArguments device;
  const auto described = describe_device(sheet.image(), {}, [](const EdsRemark&) {});
  if (described.ok()) {
    const DeviceTiming& timing = described->timing;
    device.format = format_text(described->format).view();
    device.ack_max = text_of(timing.ack_max);
    device.timeout = text_of(timing.timeout);
    device.clock_max = text_of(timing.clock_max);
    if (timing.cycle_min.count != 0) device.cycle_min = text_of(timing.cycle_min);
    return device;
  }
  const auto identifier = dump.direct_number(reg::bp_id, 2);
  if (!identifier) return device;
  const auto format = profile_format(static_cast<std::uint16_t>(*identifier));
  if (format.ok()) device.format = format_text(*format).view();
  return device;
}

// The highest ID is the first in the frame.
std::string joined_format(const std::vector<FormatArguments>& devices) {
  std::string text;
  for (auto device = devices.rbegin(); device != devices.rend(); ++device) {
    if (device->format.empty()) return {};
    if (!text.empty()) text += '+';
    text += device->format;
  }
  return text;
}

}  // namespace

std::string file_of_registers(const std::string& argument) {
  return has_id(argument) ? argument.substr(2) : argument;
}

LoadedRegisters load_registers(const std::vector<std::string>& arguments, Host& host) {
  LoadedRegisters all;
  std::vector<FormatArguments> devices;  // by ID
  std::array<bool, control_max_slaves> given{};
  for (const std::string& argument : arguments) {
    std::size_t id = devices.size();
    if (has_id(argument)) id = static_cast<std::size_t>(argument[0] - '0');
    if (id >= control_max_slaves) {
      throw wrong_usage("--registers: only eight encoders have an ID, 0 to 7");
    }
    if (std::exchange(given[id], true)) {
      throw wrong_usage("--registers: ID {} is given twice", id);
    }
    EdsArguments file;
    file.file = file_of_registers(argument);
    if (has_id(argument)) file.slave = static_cast<std::uint8_t>(id);
    const EdsSource source = load_eds(file, host);
    devices.resize(std::max(devices.size(), id + 1));
    devices[id] = device_of(source.dump, source.sheet);
    all.registers.resize(devices.size());
    all.registers[id] = registers_of(source.dump, source.sheet);
    check_eds(source.sheet.image(), [&](const EdsFinding& found) {
      // No other registers describe a channel that the data sheet leaves out.
      if (contradicts(found) ||
          (found.problem == EdsProblem::channel_count && arguments.size() == 1))
        all.contradiction = argument + ": " + finding_line(finding_row(found));
      all.findings.push_back(argument + ": " + finding_line(finding_row(found)));
    });
  }
  if (devices.size() == 1) all.device = devices[0];
  all.device.format = joined_format(devices);
  return all;
}

}  // namespace biss::verbs
