// For tests: texts to dumps and back.
#pragma once

#include <gtest/gtest.h>

#include <random>
#include <sstream>
#include <string>

#include "dump/read.hpp"

namespace biss::dump {

inline DumpResult from_text(const std::string& text, const DumpOptions& options = {}) {
  std::istringstream stream(text);
  return read_dump(stream, read_head(stream), options);
}

inline RegisterDump good(const std::string& text, const DumpOptions& options = {}) {
  const DumpResult result = from_text(text, options);
  if (result.has_value()) return *result;
  ADD_FAILURE() << dump_error_text(result.error());
  return {};
}

/// A few banks and registers with holes, all by the seed.
inline RegisterDump random_dump(std::mt19937& random) {
  RegisterDump dump;
  const auto banks = static_cast<unsigned>(random() % 4);
  const auto holes = static_cast<unsigned>(random() % 3);
  const auto byte = [&](std::optional<std::uint8_t>& at) {
    if (random() % 4 >= holes) at = static_cast<std::uint8_t>(random());
  };
  for (unsigned i = 0; i < banks; ++i) {
    const auto number = static_cast<unsigned>(random() % bank_count);
    for (unsigned at = 0; at < bank_bytes; ++at) byte(dump.at(number, at));
  }
  for (unsigned at = first_direct; at <= last_address && random() % 8 != 0; ++at) {
    byte(dump.at(0, at));
  }
  return dump;
}

/// The registers of an iC-MHM in iC-Haus' application note AN22.
inline const char* const mhm_page =
    "# iC-Haus iC-MHM; '--' = not implemented\n"
    "0x00: 48 44 00 78 80 00 00 00 CF 80 00 00 23 00 00 00\n"
    "0x10: 00 00 00 8C -- -- -- -- -- -- -- -- -- -- -- --\n"
    "0x20: -- x16\n"
    "0x30: -- x16\n"
    "0x40: 00 02 62 1E FF FF FF FF 00 00 00 00 00 00 8C FF\n"
    "0x50: FF x16\n"
    "0x60: FF x16\n"
    "0x70: 00 01 15 15 -- -- -- -- 4D 48 4D 23 44 00 69 43\n"
    "# 0x40 bank=0; 0x41 EDSBANK=2\n";

}  // namespace biss::dump
