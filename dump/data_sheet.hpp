// DataSheet: the parts of an electronic data sheet, found in a dump.
//
//   const auto sheet = biss::dump::find_data_sheet(dump, {});
//   biss::check_eds(sheet.image(), …);
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "biss/eds/image.hpp"
#include "dump/register_dump.hpp"

namespace biss::dump {

struct FindOptions {
  /// The bank of the common part; empty: what register 0x41 says, else the first that can be one.
  std::optional<std::uint8_t> eds_bank{};
  /// What the registers 0x42 and 0x43 say; empty: what they are in the dump.
  std::optional<std::uint16_t> identifier{};
};

/// A bank of a data sheet, or as much of it as is known.
struct FoundPart {
  std::uint8_t bank = 0;
  DumpedBytes bytes{};
  /// Every byte is known; only then it is judged and used.
  bool whole = false;
  /// The bytes, 0 for those not known.
  EdsBank filled{};
};

struct DataSheet {
  std::optional<FoundPart> common;
  /// By data channel, from BANK_i. Without common part a lone profile's part stands in channel 0.
  std::array<std::optional<FoundPart>, max_channels> profiles;
  /// 0x42 and 0x43, of the channel that the slave of the dump sends: that with SL_OFF's number.
  std::array<std::optional<std::uint16_t>, max_channels> identifiers;
  /// Where the common part stands, where this is known.
  std::optional<std::uint8_t> eds_bank;

  bool empty() const;
  /// What the core's functions take; only whole parts. The sheet must outlive it.
  EdsImage image() const;
};

/// Everything of a data sheet that is there; empty() where nothing is.
DataSheet find_data_sheet(const RegisterDump& dump, const FindOptions& options);

}  // namespace biss::dump
