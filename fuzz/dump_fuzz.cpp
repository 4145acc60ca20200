// The readers of register dumps on hostile files: the result is a dump or an error with a position
// in the file, in bounded memory. A dump written in any format and read again is the same.
//
// Input: bits 0 and 1 whether bank and slave are given, bit 2 the checksums of Intel HEX are
// corrected, bits 3…5 the number of repetitions of the file if bits 6 and 7 are both set; bank and
// slave; then the file.
#include <fmt/format.h>

#include <istream>
#include <sstream>
#include <streambuf>

#include "biss/eds/check.hpp"
#include "dump/data_sheet.hpp"
#include "dump/readers.hpp"
#include "dump/text.hpp"
#include "dump/write.hpp"
#include "fuzz/dump_text.hpp"
#include "fuzz/mutate.hpp"
#include "fuzz/target.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;
using namespace biss::dump;

/// A file repeated several times, stored once.
class Repeated : public std::streambuf {
 public:
  Repeated(std::string text, std::size_t times) : text_(std::move(text)), times_(times) {}
  std::size_t delivered() const { return delivered_; }

 protected:
  int_type underflow() override {
    if (times_ == 0 || text_.empty()) return traits_type::eof();
    --times_;
    delivered_ += text_.size();
    setg(text_.data(), text_.data(), text_.data() + text_.size());
    return traits_type::to_int_type(text_.front());
  }

 private:
  std::string text_;
  std::size_t times_;
  std::size_t delivered_ = 0;
};

// Sets the last byte of a record to its checksum.
void repair_record(std::span<char> record) {
  if (record.size() < 11 || record.size() % 2 == 0) return;
  unsigned sum = 0;
  for (std::size_t i = 1; i + 2 < record.size(); i += 2) {
    const auto byte = hex_number(std::string_view(&record[i], 2));
    if (!byte) return;
    sum += *byte;
  }
  const std::string digits = fmt::format("{:02X}", (0x100U - sum % 0x100U) % 0x100U);
  std::copy(digits.begin(), digits.end(), record.end() - 2);
}

void repair_records(std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    if (text[at] == ':') repair_record(std::span(text).subspan(at, end - at));
    at = end + 1;
  }
}

DumpResult read_text(const std::string& text, const DumpOptions& options = {}) {
  std::istringstream stream(text);
  return read_dump(stream, read_head(stream), options);
}

void check_same(const RegisterDump& dump, const std::string& text) {
  const DumpResult again = read_text(text);
  require(again.has_value() && *again == dump);
}

// The banks from 0 on without unknown registers: the content that a binary file can represent.
RegisterDump as_binary(const RegisterDump& dump) {
  RegisterDump filled;
  const auto range = dump.banks();
  for (std::size_t i = 0; range && i < (range->last + 1) * bank_bytes; ++i) {
    filled.at_offset(i) = dump.at_offset(i).value_or(erased);
  }
  return filled;
}

void check_binary(const RegisterDump& dump) {
  const std::string binary = write_binary(dump);
  require(binary.size() % bank_bytes == 0);
  const RegisterDump filled = as_binary(dump);
  std::istringstream stream(binary);
  require(read_binary(stream, "", {}) == filled);
  require(write_c_array(dump, "image").size() > 5 * binary.size());
  if (binary.empty() || binary.size() > 2048) return;
  check_same(filled, offsets_text(binary, true));
  check_same(filled, offsets_text(binary, false));
}

void check_accesses(const RegisterDump& dump) {
  const std::string accesses = json_text(dump);
  if (accesses.empty()) return;
  const DumpResult result = read_text(accesses);
  require(result.has_value());
  RegisterDump again = *result;
  // Accesses contain BSEL, too.
  if (!dump.direct_byte(reg::bsel)) again.at(0, reg::bsel) = std::nullopt;
  require(again == dump);
}

void check_data_sheet(const RegisterDump& dump) {
  const DataSheet sheet = find_data_sheet(dump, {});
  require(sheet.empty() || dump.banks().has_value());
  check_eds(sheet.image(), [](const EdsFinding&) {});
}

// Each input is written in one format only, because writing and reading again costs more than the
// first reading.
void check_dump(const RegisterDump& dump, unsigned way) {
  switch (way % 5U) {
    case 0:
      return check_same(dump, write_intel_hex(dump));
    case 1:
      if (!(dump == RegisterDump{})) check_same(dump, write_hex_page(dump));
      return;
    case 2:
      return check_binary(dump);
    case 3:
      return check_accesses(dump);
    default:
      return check_data_sheet(dump);
  }
}

void check_error(const DumpError& error, const std::string& text, std::size_t times) {
  require(!dump_error_text(error).empty() && name_of(error.cause) != nullptr);
  require(error.cause != DumpCause::read_failed);
  const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  require(error.line <= lines * times + 1);
  require(error.column == 0 || error.line != 0);
  require(error.column <= text.size() * times + 1);
}

DumpOptions options_of(std::uint8_t flags, std::uint8_t number) {
  switch (flags % 4U) {
    case 1:
      return {.bank = number, .slave = {}};
    case 2:
      return {.bank = {}, .slave = number % 8U};
    case 3:
      return {.bank = number % 4U, .slave = number / 32U};
    default:
      return {};
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ByteSource bytes(data, size);
  const std::uint8_t flags = bytes.next();
  const DumpOptions options = options_of(flags, bytes.next());
  std::string text(bytes.rest().begin(), bytes.rest().end());
  if ((flags & 4U) != 0) repair_records(text);
  const std::size_t times = flags >= 0xC0 ? 1U + (flags >> 3U) % 8U * 9U : 1U;
  Repeated source(text, times);
  std::istream stream(&source);
  const std::string head = read_head(stream);
  const DumpResult result = read_dump(stream, head, options);
  if (!head.empty() && recognise(head) == DumpFormat::binary) {
    require(source.delivered() <= image_bytes + head_bytes + text.size());
  }
  if (!result) {
    check_error(result.error(), text, times);
  } else {
    check_dump(*result, static_cast<unsigned>(text.size()));
  }
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  constexpr std::string_view words =
      "bank|bank 255|bank 0:|0x00:|0x40:|0x7F:|0x80:|--|x16|x64|xFFFFFFFF|48|FF|#|*|00000040|"
      "00003fc0:|ffffffff:|:00000001FF|:020000040000FA|:020000021000EC|:01400000|:10004000|\"id\":|"
      "\"read\"|\"write\"|\"command\"|\"address\":64|\"data\":[1,2]|\"echo\"|\"outcome\":\"ok\"|"
      "{\"id\":0,|}|\r\n|\t|\xEF\xBB\xBF";
  if (size < 2 || seed % 32 == 7) {
    data[0] = static_cast<std::uint8_t>(seed >> 8U);
    data[1] = static_cast<std::uint8_t>(seed >> 16U);
    if (size < 2) return 2;
  }
  if (seed % 4 == 2) return LLVMFuzzerMutate(data, size, max_size);
  return 2 +
         mutate_input({data + 2, max_size - 2}, size - 2, seed, dump_file_seed,
                      [&](std::string text, SplitMix& random) {
                        return TokenMutator(std::move(text), " \n:,\"{}", words, random).mutate();
                      });
}
