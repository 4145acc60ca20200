// Dumps of registers in all formats: read, or refused with a cause and a place inside the text;
// what was read comes back the same from hex text and Intel HEX, and a data sheet in it is judged.
//
// Input: the bank that the file begins with; bit 0 of a byte whether the slave is named; the file.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>

#include "biss/eds/check.hpp"
#include "dump/data_sheet.hpp"
#include "dump/read.hpp"
#include "dump/write.hpp"
#include "fuzz/require.hpp"

namespace {

using namespace biss;
using namespace biss::dump;
using biss::fuzz::require;

constexpr std::size_t header_bytes = 2;

DumpResult read_text(const std::string& text, const DumpOptions& options) {
  std::istringstream stream(text);
  return read_dump(stream, read_head(stream), options);
}

void check_read_again(const RegisterDump& dump) {
  if (dump == RegisterDump{}) return;
  const DumpResult page = read_text(write_hex_page(dump), {});
  require(page.ok() && *page == dump);
  const DumpResult records = read_text(write_intel_hex(dump), {});
  require(records.ok() && *records == dump);
}

void check_data_sheet(const RegisterDump& dump) {
  const DataSheet sheet = find_data_sheet(dump, {});
  check_eds(sheet.image(), [](const EdsFinding& found) { require(!found.symbol.empty()); });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < header_bytes) return 0;
  DumpOptions options;
  if (data[0] != 0) options.bank = data[0];
  if ((data[1] & 1U) != 0) options.slave = data[1] >> 1U & 7U;
  const std::string text(data + header_bytes, data + size);
  const DumpResult result = read_text(text, options);
  if (!result.ok()) {
    const auto lines = static_cast<std::uint64_t>(std::count(text.begin(), text.end(), '\n')) + 1;
    require(result.error().line <= lines);
    require(result.error().column <= max_line_bytes + 1);
    return 0;
  }
  check_read_again(*result);
  check_data_sheet(*result);
  return 0;
}
