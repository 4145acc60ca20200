#include "dump/write.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <span>

namespace biss::dump {
namespace {

constexpr std::size_t row_bytes = 16;

}  // namespace

void append_hex_rows(std::string& out, const DumpedBytes& bytes, unsigned first_address,
                     std::string_view separator) {
  for (std::size_t i = 0; i < bytes.size(); i += row_bytes) {
    const auto row = std::span(bytes).subspan(i, row_bytes);
    if (!any_known(row)) continue;
    out += fmt::format("0x{:02X}{}", first_address + i, separator);
    for (const auto& byte : row) out += byte ? fmt::format(" {:02X}", *byte) : " --";
    out += '\n';
  }
}

std::string write_hex_page(const RegisterDump& dump) {
  std::string out;
  for (unsigned number = 0; number < bank_count; ++number) {
    if (!any_known(dump.bank(number))) continue;
    out += fmt::format("bank {}\n", number);
    append_hex_rows(out, dump.bank(number), 0, ":");
  }
  append_hex_rows(out, dump.direct(), first_direct, ":");
  return out;
}

std::string write_intel_hex(const RegisterDump& dump) {
  std::string out;
  for (std::size_t at = 0; at < image_bytes;) {
    std::size_t size = 0;
    const std::size_t most = row_bytes - at % row_bytes;
    while (size < most && dump.at_offset(at + size)) ++size;
    if (size == 0) {
      ++at;
      continue;
    }
    std::size_t sum = size + (at >> 8U) + (at & 0xFFU);
    out += fmt::format(":{:02X}{:04X}00", size, at);
    for (const std::size_t end = at + size; at < end; ++at) {
      out += fmt::format("{:02X}", *dump.at_offset(at));
      sum += *dump.at_offset(at);
    }
    out += fmt::format("{:02X}\n", (0x100U - (sum & 0xFFU)) & 0xFFU);
  }
  out += ":00000001FF\n";
  return out;
}

std::string write_binary(const RegisterDump& dump, unsigned first) {
  std::string out;
  const auto range = dump.banks();
  for (unsigned number = first; range && number <= range->last; ++number) {
    for (const auto& byte : dump.bank(number)) out += static_cast<char>(byte.value_or(erased));
  }
  return out;
}

std::string write_c_array(const RegisterDump& dump, std::string_view name, unsigned first) {
  const std::string bytes = write_binary(dump, first);
  std::string out =
      fmt::format("/* Registers 0x00 to 0x3F from bank {} on, 64 bytes per bank. */\n", first);
  out += fmt::format("const unsigned char {}[{}] = {{\n", name, bytes.size());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (i % bank_bytes == 0) {
      out += fmt::format("    /* bank {} */\n", first + i / bank_bytes);
    }
    out += fmt::format("{}0x{:02X},{}", i % row_bytes == 0 ? "    " : " ",
                       static_cast<unsigned char>(bytes[i]),
                       i % row_bytes == row_bytes - 1 ? "\n" : "");
  }
  out += "};\n";
  return out;
}

std::string_view format_of(std::string_view file) {
  const std::string extension = std::filesystem::path(file).extension().string();
  if (extension == ".bin" || extension == ".eeprom") return "bin";
  if (extension == ".ihex" || extension == ".ihx" || extension == ".ihe") return "ihex";
  if (extension == ".c" || extension == ".h" || extension == ".inc") return "c";
  return "hex";
}

bool holds_banks_only(std::string_view format) { return format == "bin" || format == "c"; }

std::string write_as(std::string_view format, const RegisterDump& dump, std::string_view name,
                     unsigned first) {
  if (format == "bin") return write_binary(dump, first);
  if (format == "ihex") return write_intel_hex(dump);
  if (format == "c") return write_c_array(dump, name, first);
  return write_hex_page(dump);
}

std::string text_of_banks(const RegisterDump& dump, unsigned first) {
  const unsigned last = dump.banks()->last;
  return fmt::format(
      "banks {} to {}, {} bytes; this format has no place for the registers from 0x40 on\n", first,
      last, (last - first + 1) * bank_bytes);
}

std::string text_without_bank(const RegisterDump& dump) {
  return fmt::format(
      "left out: {} register{} from 0x00 to 0x3F of which no access shows the bank (BSEL, 0x40)",
      dump.without_bank, dump.without_bank == 1 ? "" : "s");
}

}  // namespace biss::dump
