// Damaged and random text: the result is a named error or a dump.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>

#include "dump/test_dumps.hpp"
#include "dump/write.hpp"

namespace biss::dump {
namespace hostile_test {

std::string json_of(const RegisterDump& dump) {
  std::string out;
  for (unsigned at = 0; at < bank_bytes; ++at) {
    if (!dump.direct()[at]) continue;
    out += "{\"id\":0,\"access\":\"read\",\"address\":" + std::to_string(first_direct + at) +
           ",\"data\":" + std::to_string(*dump.direct()[at]) + ",\"outcome\":\"ok\"}\n";
  }
  return out;
}

std::string offsets_of(const RegisterDump& dump) {
  const std::string bytes = write_binary(dump);
  std::string out;
  for (std::size_t i = 0; i < bytes.size() && i < 4096; ++i) {
    if (i % 16 == 0) out += fmt::format("{}{:08x}:", i == 0 ? "" : "\n", i);
    out += fmt::format(" {:02x}", static_cast<unsigned char>(bytes[i]));
  }
  return out + "\n*\n";
}

std::string damaged(std::string text, std::mt19937& random) {
  constexpr std::string_view alphabet = "0123456789ABCDEFx:-*#|{}[]\",. \t\r\n\0\xFF";
  const auto times = static_cast<unsigned>(1 + random() % 4);
  for (unsigned i = 0; i < times && !text.empty(); ++i) {
    const std::size_t at = random() % text.size();
    const char c = alphabet[random() % alphabet.size()];
    switch (random() % 5) {
      case 0:
        text[at] = c;
        break;
      case 1:
        text.insert(at, 1, c);
        break;
      case 2:
        text.erase(at, 1 + random() % 3);
        break;
      case 3:
        text.resize(at);
        break;
      default:
        text.insert(at, text.substr(random() % text.size(), random() % 64));
        break;
    }
  }
  return text;
}

TEST(Hostile, DamagedDumpsOfEveryFormat_AreRefusedOrRead) {
  constexpr unsigned seed = 4711;
  std::mt19937 random(seed);
  unsigned refused = 0;
  for (int i = 0; i < 4000; ++i) {
    const RegisterDump dump = random_dump(random);
    const std::array texts{write_hex_page(dump), write_intel_hex(dump), json_of(dump),
                           offsets_of(dump), write_binary(dump).substr(0, 1024)};
    const std::string text = damaged(texts[random() % texts.size()], random);
    const DumpResult result = from_text(text, {.bank = static_cast<std::uint8_t>(random() % 3)});
    if (!result.has_value()) {
      ++refused;
      ASSERT_LT(static_cast<unsigned>(result.error().cause), 14U);
      ASSERT_FALSE(dump_error_text(result.error()).empty());
    } else if (!(*result == RegisterDump{})) {
      ASSERT_EQ(good(write_intel_hex(*result)), *result) << "seed " << seed << ", text " << i;
    }
  }
  EXPECT_GT(refused, 500U) << "the damage is too mild to show anything";
  EXPECT_LT(refused, 3900U);
}

TEST(Hostile, DamagedIntelHex_IsNeverReadAsAnotherDump) {
  constexpr unsigned seed = 99;
  std::mt19937 random(seed);
  RegisterDump dump;
  for (unsigned at = 0; at < bank_bytes; ++at) dump.at(2, at) = static_cast<std::uint8_t>(random());
  const std::string text = write_intel_hex(dump);
  for (std::size_t at = 0; at < text.size(); ++at) {
    std::string other = text;
    other[at] = other[at] == '5' ? 'A' : '5';  // one digit, so the sum cannot hold
    const DumpResult result = from_text(other);
    if (other[at] == text[at] || text[at] == '\n') continue;
    EXPECT_FALSE(result.has_value() && !(*result == dump)) << at;
  }
}

TEST(Hostile, DeeplyNestedJson_IsRefused) {
  const DumpResult result = from_text("{\"a\":" + std::string(15'000, '[') + "\n");
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().cause, DumpCause::malformed);
}

TEST(Hostile, EndlessLine_IsRefusedInBoundedMemory) {
  EXPECT_EQ(from_text("0x00: " + std::string(1'000'000, ' ')).error().cause,
            DumpCause::line_too_long);
}

}  // namespace hostile_test
}  // namespace biss::dump
