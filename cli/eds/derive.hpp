// What follows of a data sheet from the rest of it.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "biss/eds/bank.hpp"
#include "biss/eds/field.hpp"
#include "biss/frame/format.hpp"
#include "dump/register_dump.hpp"

namespace biss::cli {

/// A part of which some bytes have been given.
struct PartInWork {
  EdsBank bank{};
  std::array<bool, eds_bank_bytes> given{};

  /// \pre the value fits the field
  void set(const EdsField& field, std::uint32_t value);
  /// The same, unless the field was given; true when it was set.
  bool fill(const EdsField& field, std::uint32_t value);
};

struct PartsInWork {
  std::optional<PartInWork> common;
  std::array<std::optional<PartInWork>, max_channels> profiles;
  /// Registers and further banks as given; the parts are put into it.
  dump::RegisterDump dump;
};

/// Fills in what was not given (eds_description.hpp lists it) and puts the parts into their banks:
/// the common part where EDS_BANK says, in bank 1 when it says nothing, a channel's where BANK_i
/// says. Without common part channel i stands in bank i. Returns why that cannot be, or nothing.
std::string fill_in(PartsInWork& parts);

}  // namespace biss::cli
