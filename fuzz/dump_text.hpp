// Register dumps as text, in formats that dump/ only reads; dumps as seeds.
#pragma once

#include <fmt/format.h>

#include <iterator>
#include <random>

#include "dump/register_dump.hpp"
#include "dump/write.hpp"
#include "fuzz/register_seeds.hpp"
#include "fuzz/target.hpp"

namespace biss::fuzz {

/// The output of xxd or hexdump -C for a binary.
inline std::string offsets_text(const std::string& binary, bool xxd) {
  std::string out;
  for (std::size_t i = 0; i < binary.size(); i += 16) {
    fmt::format_to(std::back_inserter(out), "{:08x}{}", i, xxd ? ":" : " ");
    for (std::size_t k = i; k < i + 16 && k < binary.size(); ++k) {
      const bool apart = !xxd || k % 2 == 0;
      fmt::format_to(std::back_inserter(out), "{}{:02x}", apart ? " " : "",
                     static_cast<unsigned char>(binary[k]));
    }
    out += xxd ? "  ................\n" : "  |................|\n";
  }
  return out;
}

/// Accesses that read the complete dump: BSEL written, then runs of registers read. BSEL itself
/// comes last, if it is known.
inline std::string json_text(const dump::RegisterDump& dump) {
  std::string out;
  const auto row = [&](const char* access, unsigned address, const std::string& data) {
    fmt::format_to(std::back_inserter(out),
                   R"({{"id":3,"access":"{}","address":{},"data":"{}","outcome":"ok"}})"
                   "\n",
                   access, address, data);
  };
  const auto rows = [&](const dump::DumpedBytes& bytes, unsigned first, std::size_t from) {
    std::string run;
    for (std::size_t i = from; i <= bytes.size(); ++i) {
      const bool known = i < bytes.size() && bytes[i].has_value();
      const std::size_t size = run.size() / 2;
      if (!known && size != 0) row("read", first + static_cast<unsigned>(i - size), run);
      if (!known) run.clear();
      if (known) fmt::format_to(std::back_inserter(run), "{:02X}", *bytes[i]);
    }
  };
  const auto range = dump.banks();
  for (unsigned number = range ? range->first : 1; range && number <= range->last; ++number) {
    if (dump.known_bytes(number) == 0) continue;
    row("write", reg::bsel, fmt::format("{:02X}", number));
    rows(dump.bank(number), 0, 0);
  }
  rows(dump.direct(), dump::first_direct, 1);
  if (const auto bsel = dump.direct_byte(reg::bsel)) {
    row("read", reg::bsel, fmt::format("{:02X}", *bsel));
  }
  return out;
}

/// A data sheet, or a few banks and registers with holes.
inline dump::RegisterDump dump_seed(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  dump::RegisterDump dump;
  if (seed % 4 == 3) {
    constexpr std::uint8_t eds_bank = 2;
    unsigned number = eds_bank;
    for (const EdsBank& bank : eds_banks_seed(seed, eds_bank)) dump.set_bank(number++, bank);
    dump.at(0, reg::eds_bank) = eds_bank;
    return dump;
  }
  const std::uint64_t holes = random() % 3;
  const auto put = [&](unsigned bank, unsigned address) {
    if (random() % 8 >= holes) dump.at(bank, address) = static_cast<std::uint8_t>(random());
  };
  for (std::uint64_t i = 0; i < 1 + seed % 2; ++i) {
    const auto bank = static_cast<unsigned>(random() % 5);
    for (unsigned address = 0; address < bank_bytes; ++address) put(bank, address);
  }
  const auto direct = static_cast<unsigned>(random() % bank_bytes);
  for (unsigned i = 0; i < direct; ++i) put(0, dump::first_direct + i);
  return dump;
}

/// One file in every readable format.
inline std::string dump_file_seed(std::uint64_t seed) {
  const dump::RegisterDump dump = dump_seed(seed);
  switch (seed % 6) {
    case 0:
      return write_hex_page(dump);
    case 1:
      return write_intel_hex(dump);
    case 2:
      return json_text(dump);
    case 3:
      return offsets_text(write_binary(dump), true);
    case 4:
      return offsets_text(write_binary(dump), false);
    default:
      return write_binary(dump);
  }
}

}  // namespace biss::fuzz
