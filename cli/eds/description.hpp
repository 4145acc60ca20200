// A data sheet as readable text: what a maker writes, and what `eds show --to description` prints.
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
// What is left out and can be derived is filled in: checksums, versions, EDS_LEN, DC_NUM, SL_NUM,
// BANK_i, DLEN_i, CPOLY_i, BP_ID, FB1, FB2, POS_NUM, CPOLY, and the registers EDS_BANK and BP_ID.
// docs/eds.md has the rules. What is given stays as given; whether it fits is for check_eds().
#pragma once

#include <istream>
#include <string>
#include <string_view>

#include "dump/data_sheet.hpp"
#include "dump/register_dump.hpp"

namespace biss::cli {

/// Whether a text begins as a description does: with a section, blank lines and comments before it.
bool looks_like_description(std::string_view head);

/// The dump that a description makes, or the one line why there is none, with the line's number.
struct DescribedDump {
  dump::RegisterDump dump;
  std::string error;
};

/// Reads a description to its end; `head` is what was read of the stream already.
DescribedDump read_description(std::istream& stream, std::string head);

/// The description of a dump whose parts are those of `sheet`; read again it gives the same bytes,
/// and the registers EDS_BANK and BP_ID even where the dump had none.
std::string write_description(const dump::RegisterDump& dump, const dump::DataSheet& sheet);

}  // namespace biss::cli
