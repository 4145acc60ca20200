// DataSheet: the parts of an electronic data sheet in a dump.
//
//   const auto sheet = biss::dump::find_data_sheet(dump, {});
//   biss::check_eds(sheet.image(), …);
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "biss/eds/image.hpp"
#include "dump/register_dump.hpp"

namespace biss::dump {

struct FindOptions {
  /// The bank of the common part. Empty: register 0x41, else the first bank that can be one.
  std::optional<std::uint8_t> eds_bank{};
  /// The registers 0x42 and 0x43; empty: from the dump.
  std::optional<std::uint16_t> identifier{};
};

/// A bank of a data sheet, as far as it is known.
struct FoundPart {
  std::uint8_t bank = 0;
  DumpedBytes bytes{};
  /// Every byte is known; only then the part is judged and used.
  bool whole = false;
  /// The bytes; unknown ones are 0.
  EdsBank filled{};
};

struct DataSheet {
  std::optional<FoundPart> common;
  /// By data channel, from BANK_i. Without common part, a single profile part belongs to channel 0.
  std::array<std::optional<FoundPart>, max_channels> profiles;
  /// The registers 0x42 and 0x43, for the channel that this slave sends (SL_OFF).
  std::array<std::optional<std::uint16_t>, max_channels> identifiers;
  /// The bank of the common part, if it is known.
  std::optional<std::uint8_t> eds_bank;

  bool empty() const;
  /// The whole parts, for the core's functions. \pre the sheet outlives the image
  EdsImage image() const;
};

/// The parts of a data sheet in the dump; empty() if there are no parts.
DataSheet find_data_sheet(const RegisterDump& dump, const FindOptions& options);

}  // namespace biss::dump
