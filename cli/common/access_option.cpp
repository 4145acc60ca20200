#include "cli/common/access_option.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>

#include "cli/common/quantity.hpp"
#include "dump/hex_digits.hpp"

namespace biss::cli {

namespace {

using sim::AccessKind;
using sim::ControlAccess;

constexpr std::array<const char*, 4> command_names{"channels", "control", "bypass", "user"};
constexpr std::array<std::string_view, 3> when_names{"all", "any", "always"};
constexpr std::size_t longest_line = 4096;

// What stands before the mark, which is taken off; all of it where there is none.
std::string_view take_until(std::string_view& rest, char mark) {
  const std::size_t at = std::min(rest.find(mark), rest.size());
  const std::string_view part = rest.substr(0, at);
  rest.remove_prefix(std::min(at + 1, rest.size()));
  return part;
}

std::optional<std::uint8_t> number(std::string_view text, unsigned least, unsigned largest) {
  const auto value = parse_count(text, largest);
  if (!value.ok() || *value < least) return std::nullopt;
  return static_cast<std::uint8_t>(*value);
}

std::string read_ids(std::string_view text, ControlAccess& access) {
  while (!text.empty()) {
    const auto id = number(take_until(text, ','), 0, control_max_slaves - 1);
    if (!id) return "an ID is 0 to 7";
    access.slave = *id;
    access.slaves = static_cast<std::uint8_t>(access.slaves | 1U << *id);
  }
  return {};
}

std::string read_bytes(std::string_view text, std::vector<std::uint8_t>& bytes) {
  for (; text.size() >= 2; text.remove_prefix(2)) {
    const auto byte = dump::hex_number(text.substr(0, 2));
    if (!byte) break;
    bytes.push_back(static_cast<std::uint8_t>(*byte));
  }
  if (text.empty() && !bytes.empty() && bytes.size() <= sequential_max_bytes) return {};
  return "bytes are two hexadecimal digits each, 1 to 64 of them";
}

// Registers of one access, the last one included.
std::string check_registers(const ControlAccess& access, std::size_t count) {
  if (!(access.slaves & (access.slaves - 1U))) {
    if (access.address + count <= register_count) return {};
    return fmt::format("there are {} registers from 0x{:02X} on, not {}",
                       register_count - access.address, access.address, count);
  }
  return "registers are those of one slave; give one ID";
}

std::string read_registers(std::string_view rest, ControlAccess& access) {
  const char mark = access.kind == AccessKind::read ? ',' : '=';
  const bool more = rest.find(mark) != std::string_view::npos;
  const auto address = number(take_until(rest, mark), 0, register_count - 1);
  if (!address) return "an address is 0 to 0x7F";
  access.address = *address;
  if (access.kind == AccessKind::write) {
    if (!more) return "write:ADDRESS=BYTES";
    std::string wrong = read_bytes(rest, access.data);
    return wrong.empty() ? check_registers(access, access.data.size()) : wrong;
  }
  if (more) {
    const auto count = number(rest, 1, sequential_max_bytes);
    if (!count) return "a count is 1 to 64";
    access.size = *count;
  }
  return check_registers(access, access.size);
}

std::string read_command(std::string_view rest, ControlAccess& access) {
  const bool with_when = rest.find(',') != std::string_view::npos;
  const std::string_view name = take_until(rest, ',');
  const auto named = std::find(command_names.begin(), command_names.end(), name);
  const auto numbered = number(name, 0, command_names.size() - 1);
  if (named == command_names.end() && !numbered) {
    return "a command is channels, control, bypass, user or 0 to 3";
  }
  access.command = static_cast<ControlCommand>(
      numbered ? *numbered : static_cast<std::uint8_t>(named - command_names.begin()));
  if (access.slaves == 0) {
    access.kind = AccessKind::broadcast;
    return with_when ? "a broadcast has no answers to wait for" : "";
  }
  if (!with_when) return {};
  const auto when = std::find(when_names.begin(), when_names.end(), rest);
  if (when == when_names.end()) return "a command goes when all, any or always";
  access.execute_if = static_cast<ExecuteIf>(when - when_names.begin());
  return {};
}

std::string read_parts(std::string_view text, ControlAccess& access) {
  const std::size_t at = text.rfind('@');
  if (at != std::string_view::npos) {
    const auto cycle = parse_count(text.substr(at + 1));
    if (!cycle.ok()) return "behind @ stands the number of a cycle";
    access.not_before = *cycle;
    text = text.substr(0, at);
  }
  if (text.find('/') != std::string_view::npos) {
    const std::string_view ids = take_until(text, '/');
    if (ids.empty()) return "an ID is 0 to 7";
    if (std::string wrong = read_ids(ids, access); !wrong.empty()) return wrong;
  }
  const std::string_view kind = take_until(text, ':');
  if (kind == "command") {
    access.kind = AccessKind::command;
    return read_command(text, access);
  }
  if (kind != "read" && kind != "write") return "read:…, write:… or command:…";
  access.kind = kind == "read" ? AccessKind::read : AccessKind::write;
  return read_registers(text, access);
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

void read_file(const std::string& path, AccessChoice& choice) {
  std::error_code ignored;
  std::ifstream file(path);
  if (!file || std::filesystem::is_directory(path, ignored)) {
    choice.error = fmt::format("--access: {}: cannot be opened", path);
    choice.status = ExitStatus::io;
    return;
  }
  std::string line;
  for (std::uint64_t count = 1; std::getline(file, line); ++count) {
    const std::string text(trimmed(std::string_view(line).substr(0, line.find('#'))));
    if (text.empty()) continue;
    ControlAccess access;
    std::string wrong = line.size() > longest_line ? "line too long" : read_access(text, access);
    if (!wrong.empty()) {
      choice.error = fmt::format("{}: line {}: {}", path, count, wrong);
      choice.status = ExitStatus::io;
      return;
    }
    choice.accesses.push_back(std::move(access));
  }
}

}  // namespace

const char* name_of(ControlCommand command) {
  return command_names[static_cast<std::size_t>(command)];
}

std::string read_access(const std::string& text, ControlAccess& access) {
  access = {};
  const std::string wrong = read_parts(text, access);
  if (wrong.empty()) return {};
  return fmt::format("--access: '{}': {}", text, wrong);
}

AccessChoice read_accesses(const std::vector<std::string>& texts) {
  AccessChoice choice;
  for (const std::string& text : texts) {
    if (text.starts_with('@')) {
      read_file(text.substr(1), choice);
    } else {
      ControlAccess access;
      choice.error = read_access(text, access);
      if (!choice.error.empty()) choice.status = ExitStatus::usage;
      choice.accesses.push_back(std::move(access));
    }
    if (!choice.error.empty()) return choice;
  }
  return choice;
}

std::uint64_t least_cycles(const std::vector<ControlAccess>& accesses) {
  std::uint64_t cycle = control_reset_zeros;
  for (const ControlAccess& access : accesses) {
    cycle = std::max(cycle, access.not_before) + sim::least_cycles(access);
  }
  return accesses.empty() ? 0 : cycle;
}

}  // namespace biss::cli
