// A description: a data sheet as readable text, as makers write it and as
// `biss eds show --to description` prints it.
//
//     [registers]
//     MFR_ID = 0x6943
//     0x48 = 00 01 FF         # bytes from this register on
//     [common]
//     TMA = 100ns
//     [bp3]                   # of data channel 0; [bp3 1] of channel 1
//     EN_TYP = rotary
//     MT_LEN = 12 bit
//     [bank 5]
//     0x00 = 01 02 03
//
// Fields that are left out are derived if they follow from the rest: see draft.hpp. This includes
// the registers EDS_BANK and BP_ID. docs/eds.md has the rules. Given values stay as given;
// check_eds() judges whether they fit.
#pragma once

#include <istream>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "dump/data_sheet.hpp"
#include "dump/register_dump.hpp"

namespace biss::verbs {

/// Whether a text begins as a description does: its first line that is not empty is a section.
bool looks_like_description(std::string_view head);

struct Description {
  dump::RegisterDump dump;
  /// The parts that a description gives by fields, even those to which no register leads; empty
  /// for other files.
  dump::DataSheet drafted;
};

/// Reads a description to its end; `head` holds the bytes already read from the stream. An error is
/// one line of text with the line's number.
tl::expected<Description, std::string> read_description(std::istream& stream, std::string head);

/// The description of a dump with the parts of `sheet`. Reading it gives the same bytes, and the
/// registers EDS_BANK and BP_ID even if the dump had none.
std::string write_description(const dump::RegisterDump& dump, const dump::DataSheet& sheet);

}  // namespace biss::verbs
