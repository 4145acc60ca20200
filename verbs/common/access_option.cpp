#include "verbs/common/access_option.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "device/quantity.hpp"
#include "dump/text.hpp"
#include "verbs/common/text_file.hpp"

namespace biss::verbs {

namespace {

using sim::AccessKind;
using sim::ControlAccess;

constexpr std::array<const char*, 4> command_names{"channels", "control", "bypass", "user"};
constexpr std::array<std::string_view, 3> when_names{"all", "any", "always"};

// Removes and returns the text before the mark, or all of it if there is no mark.
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

std::string read_registers(std::string_view rest, ControlAccess& access) {
  const bool is_read = access.kind == AccessKind::read;
  const char mark = is_read ? ',' : '=';
  const bool more = rest.find(mark) != std::string_view::npos;
  const auto address = number(take_until(rest, mark), 0, register_count - 1);
  if (!address) return "the address must be 0 to 0x7F";
  access.address = *address;
  if (!is_read && !more) return "expected write:ADDRESS=BYTES";
  if (is_read && more) {
    const auto count = number(rest, 1, sequential_max_bytes);
    if (!count) return "the count must be 1 to 64";
    access.size = *count;
  } else if (more) {
    while (const auto byte = dump::hex_byte(rest.substr(0, 2))) {
      access.data.push_back(*byte);
      rest.remove_prefix(2);
    }
    if (!rest.empty() || access.data.empty() || access.data.size() > sequential_max_bytes) {
      return "give 1 to 64 bytes, each as two hexadecimal digits";
    }
  }
  if ((access.slaves & (access.slaves - 1U)) != 0) {
    return "give one ID: a register access addresses one slave";
  }
  const std::size_t count = is_read ? access.size : access.data.size();
  if (access.address + count <= register_count) return {};
  return fmt::format("only {} registers follow from 0x{:02X} on, not {}",
                     register_count - access.address, access.address, count);
}

std::string read_command(std::string_view rest, ControlAccess& access) {
  const bool with_when = rest.find(',') != std::string_view::npos;
  const std::string_view name = take_until(rest, ',');
  const auto named = std::find(command_names.begin(), command_names.end(), name);
  const auto numbered = number(name, 0, command_names.size() - 1);
  if (named == command_names.end() && !numbered) {
    return "the command must be channels, control, bypass, user or 0 to 3";
  }
  access.command = static_cast<ControlCommand>(
      numbered ? *numbered : static_cast<std::uint8_t>(named - command_names.begin()));
  if (access.slaves == 0) {
    access.kind = AccessKind::broadcast;
    return with_when ? "a broadcast has no answers; remove the condition" : "";
  }
  if (!with_when) return {};
  const auto when = std::find(when_names.begin(), when_names.end(), rest);
  if (when == when_names.end()) return "the condition must be all, any or always";
  access.execute_if = static_cast<ExecuteIf>(when - when_names.begin());
  return {};
}

std::string read_parts(std::string_view text, ControlAccess& access) {
  const std::size_t at = text.rfind('@');
  if (at != std::string_view::npos) {
    const auto cycle = parse_count(text.substr(at + 1));
    if (!cycle.ok()) return "a cycle number must follow @";
    access.not_before = *cycle;
    text = text.substr(0, at);
  }
  if (text.find('/') != std::string_view::npos) {
    std::string_view ids = take_until(text, '/');
    do {
      const auto id = number(take_until(ids, ','), 0, control_max_slaves - 1);
      if (!id) return "the ID must be 0 to 7";
      access.slave = *id;
      access.slaves = static_cast<std::uint8_t>(access.slaves | 1U << *id);
    } while (!ids.empty());
  }
  const std::string_view kind = take_until(text, ':');
  if (kind == "command") {
    access.kind = AccessKind::command;
    return read_command(text, access);
  }
  if (kind != "read" && kind != "write") return "expected read:…, write:… or command:…";
  access.kind = kind == "read" ? AccessKind::read : AccessKind::write;
  return read_registers(text, access);
}

using Accesses = std::vector<ControlAccess>;

}  // namespace

const char* name_of(ControlCommand command) {
  return command_names[static_cast<std::size_t>(command)];
}

tl::expected<ControlAccess, std::string> read_access(const std::string& text) {
  ControlAccess access;
  const std::string wrong = read_parts(text, access);
  if (wrong.empty()) return access;
  const bool cut = text.size() > 60;
  return tl::make_unexpected(
      fmt::format("--access: '{}{}': {}", text.substr(0, 60), cut ? "..." : "", wrong));
}

Accesses read_accesses(const std::vector<std::string>& texts) {
  Accesses accesses;
  for (const std::string& text : texts) {
    if (const std::string path = file_of_accesses(text); !path.empty()) {
      read_lines("--access", path, [&](std::string_view line) {
        if (accesses.size() == max_accesses) {
          return fmt::format("more than {} accesses", max_accesses);
        }
        auto access = read_access(std::string(line));
        if (!access) return access.error();
        accesses.push_back(std::move(*access));
        return std::string();
      });
    } else {
      accesses.push_back(value_or_fail(read_access(text)));
    }
  }
  return accesses;
}

std::string file_of_accesses(const std::string& text) {
  return text.starts_with('@') ? text.substr(1) : std::string();
}

std::uint64_t least_cycles(const std::vector<ControlAccess>& accesses) {
  std::uint64_t cycle = control_reset_zeros;
  for (const ControlAccess& access : accesses) {
    cycle = std::max(cycle, access.not_before) + sim::least_cycles(access);
  }
  return accesses.empty() ? 0 : cycle;
}

}  // namespace biss::verbs
