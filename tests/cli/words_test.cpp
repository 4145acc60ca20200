// Words without a line: the text of a buffer in `crc --read`, a log of them in `decode --words`, and
// how a word is read that has its bits or bytes in another order.
#include "tests/cli/run_command.hpp"

namespace biss::verbs::words_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* format18 = "pos18,nE,nW,crc6";

Outcome crc(const std::string& text, const Words& more = {}, const std::string& format = format18) {
  return run(Words{"crc", "-f", format, "--read", text} + more);
}

// The position that a text is read as; the message if there is none.
std::string position_of(const std::string& text, const Words& more = {},
                        const std::string& format = format18) {
  const Outcome outcome = crc(text, more + Words{"--to", "jsonl"}, format);
  const std::string key = "{\"position\":";
  if (outcome.status != 0 || !outcome.out.starts_with(key)) return outcome.out + outcome.err;
  return outcome.out.substr(key.size(), outcome.out.find(',') - key.size());
}

// Bits of a frame from START to the last one of the CRC.
std::string frame_of(const std::string& format, std::uint64_t position) {
  const std::string out = run("crc -f {} {} --to jsonl", format, std::to_string(position)).out;
  const std::string key = "\"bits\":\"";
  const std::size_t at = out.find(key) + key.size();
  return out.substr(at, out.find('"', at) - at);
}

// SLO once a clock: leading ones, ACK, the frame, then zeros up to a whole number of bytes.
std::string line_of(const std::string& format, std::uint64_t position, std::size_t ack = 35,
                    std::size_t bytes = 0) {
  std::string bits = "1111" + std::string(ack, '0') + frame_of(format, position) + "0";
  bits.resize(std::max(bytes * 8, (bits.size() + 7) / 8 * 8), '0');
  return bits;
}

std::string hex_of(const std::string& bits) {
  std::string out;
  for (std::size_t i = 0; i < bits.size(); i += 4) {
    out += fmt::format("{:X}", std::stoul(bits.substr(i, 4), nullptr, 2));
  }
  return out;
}

std::string inverted(std::string bits) {
  for (char& bit : bits) bit = bit == '0' ? '1' : '0';
  return bits;
}

std::string reversed_bytes(std::string bits) {
  for (std::size_t i = 0; i < bits.size(); i += 8) {
    std::reverse(bits.begin() + static_cast<std::ptrdiff_t>(i),
                 bits.begin() + static_cast<std::ptrdiff_t>(i + 8));
  }
  return bits;
}

std::string little_endian(const std::string& bits, std::size_t word_bits) {
  std::string out;
  for (std::size_t i = 0; i < bits.size(); i += word_bits) {
    for (std::size_t byte = word_bits; byte > 0; byte -= 8) out += bits.substr(i + byte - 8, 8);
  }
  return out;
}

// ---- crc --read: the digits

TEST(CrcReadText, BinaryDigits_AreReadAsBits) {
  const std::string bits = line_of(format18, 74565);
  ASSERT_GE(bits.size(), 64U);
  EXPECT_EQ(position_of(bits), "74565");
  EXPECT_EQ(position_of("0b" + bits), "74565");
  std::string in_fours;
  for (std::size_t i = 0; i < bits.size(); i += 4) in_fours += bits.substr(i, 4) + " ";
  EXPECT_EQ(position_of(in_fours), "74565");
  // Their number needs to be no multiple of 4.
  EXPECT_EQ(position_of(bits.substr(0, bits.size() - 3)), "74565");
}

TEST(CrcReadText, ShortDigits0And1_AreHexadecimal) {
  // 24 bits, not 6: the shortest frame of this format has more than 6.
  EXPECT_EQ(position_of("110010", {}, "pos1,pad1,crc3"),
            position_of("0x11 0x00 0x10", {}, "pos1,pad1,crc3"));
}

TEST(CrcReadText, NotationsOfToolsAndSources_AreTheSameBytes) {
  for (const char* const text :
       {"F0:00:00:00:01:24:68:B9:A0", "F0-00-00-00-01-24-68-B9-A0",
        "\\xF0\\x00\\x00\\x00\\x01\\x24\\x68\\xB9\\xA0",
        "b'\\xf0\\x00\\x00\\x00\\x01\\x24\\x68\\xb9\\xa0'", "240, 0, 0, 0, 1, 36, 104, 185, 160",
        "[240, 0, 0, 0, 1, 36, 104, 185, 160]", "240 0 0 0 1 36 104 185 160",
        "0xF0, 0x00, 0x00, 0x00, 0x01, 0x24, 0x68, 0xB9, 0xA0",
        "const uint8_t rx[9] = {0xF0, 0, 0, 0, 1, 0x24, 0x68, 0xB9, 0xA0};",
        "{0xF0u, 0x00u, 0x00u, 0x00u, 0x01u, 0x24u, 0x68u, 0xB9u, 0xA0u}",
        "0xF0000000012468B9A0"}) {
    EXPECT_EQ(position_of(text), "74565") << text;
  }
}

TEST(CrcReadText, TextThatIsNoBuffer_IsOneLine) {
  for (const char* const text :
       {"-16, 0, 0, 0, 1, 36, 104, -71, -96", "240, 0, 256", "00000000: f000 0000 0124 68b9 a0",
        "C0:5", "C0--05", "0b102", "\\xF0\\x00AB", "\\xF", "{}", "0x", "1.5, 2", "F0:00 -"}) {
    EXPECT_THAT(crc(text), refuses(2, "")) << text;
  }
}

TEST(CrcReadText, TwoReadingsThatBothFit_AreBothNamedAndNoneIsChosen) {
  // Good frames as the bytes C0 14 40 and as C0 0E 28.
  const std::string format = "pos1,pad1,crc3";
  const std::string text = "0xC0 14 40";
  EXPECT_THAT(crc(text, {}, format),
              fails(2, AllOf(HasSubstr("--digits hex"), HasSubstr("--digits decimal"))))
      << text;
  EXPECT_EQ(crc(text, {"--digits", "hex"}, format).status, 0);
  EXPECT_EQ(crc(text, {"--digits", "decimal"}, format).status, 0);
}

// ---- crc --read: the variants

// The result names the option that reads this buffer, and that option reads it.
void expect_named(const std::string& text, const Words& option, const std::string& position,
                  const std::string& format) {
  const Outcome outcome = crc(text, {}, format);
  EXPECT_EQ(outcome.status, 1) << text << outcome.out << outcome.err;
  std::string joined;
  for (const std::string& word : option) joined += (joined.empty() ? "" : " ") + word;
  EXPECT_THAT(outcome.err, HasSubstr(joined)) << text;
  EXPECT_EQ(position_of(text, option, format), position) << joined;
}

constexpr const char* format32 = "pos32,nE,nW,crc16";
constexpr std::uint64_t position32 = 0x5A3C'9617;
constexpr const char* position32_text = "1513920023";

TEST(CrcReadVariants, ReversedBitsOfEachByte_AreNamed) {
  const std::string bits = reversed_bytes(line_of(format32, position32));
  expect_named(hex_of(bits), "--bit-order lsb", position32_text, format32);
}

TEST(CrcReadVariants, LittleEndianWords_AreNamed) {
  const std::string bits = line_of(format32, position32, 37, 16);
  ASSERT_EQ(bits.size(), 128U);
  expect_named(hex_of(little_endian(bits, 16)), "--byte-order little16", position32_text, format32);
  expect_named(hex_of(little_endian(bits, 32)), "--byte-order little32", position32_text, format32);
  expect_named(hex_of(little_endian(bits, 64)), "--byte-order little64", position32_text, format32);
  expect_named(hex_of(little_endian(bits, 128)), "--byte-order little", position32_text, format32);
}

TEST(CrcReadVariants, SwappedWires_AreNamed) {
  expect_named(hex_of(inverted(line_of(format32, position32))), {"--invert"}, position32_text,
               format32);
}

TEST(CrcReadVariants, OneBitEarlyOrLate_IsNamed) {
  const std::string bits = line_of(format32, position32, 37);
  expect_named(hex_of("0" + bits.substr(0, bits.size() - 1)), "--first-bit 1", position32_text,
               format32);
  // The leading ones are missing, and a part of ACK.
  expect_named(hex_of(bits.substr(4) + "0000"), "--first-bit -1", position32_text, format32);
}

TEST(CrcReadVariants, FewerClocksThanBits_AreNamed) {
  std::string bits = "1111" + std::string(36, '0') + frame_of(format32, position32);
  const std::string clocks = std::to_string(bits.size());
  bits.resize((bits.size() + 15) / 8 * 8, '1');
  expect_named(hex_of(bits), {"--bits", clocks}, position32_text, format32);
}

TEST(CrcReadVariants, PayloadWithoutAckAndStart_IsNamed) {
  const std::string payload = frame_of(format32, position32).substr(2);
  const std::string right = std::string(64 - payload.size(), '0') + payload;
  expect_named(hex_of(right), {"--payload"}, position32_text, format32);
  expect_named(hex_of(payload + std::string(64 - payload.size(), '0')),
               {"--payload", "--bits", std::to_string(payload.size())}, position32_text, format32);
  expect_named(hex_of(little_endian(right, 64)), "--payload --byte-order little", position32_text,
               format32);
}

TEST(CrcReadVariants, RawOfARow_IsRead) {
  // START to STOP, with leading zeros: the column `raw` of decode.
  const std::string raw = "000" + frame_of("pos26,nE,nW,crc6", 1234567) + "0";
  const Outcome outcome = crc("0x" + hex_of("0" + raw), {}, "pos26,nE,nW,crc6");
  EXPECT_THAT(outcome.err, HasSubstr("--first-bit -1"));
  EXPECT_EQ(position_of("0x" + hex_of("0" + raw), {"--first-bit", "-1"}, "pos26,nE,nW,crc6"),
            "1234567");
  // The first bit is START.
  const std::string from_start = frame_of(format32, position32) + "0000";
  expect_named(hex_of(from_start + std::string(from_start.size() % 8, '0')), "--first-bit -2",
               position32_text, format32);
}

TEST(CrcReadVariants, ShortChecksumOfOneBuffer_IsSaidToBeUnsure) {
  const std::string bits = hex_of(inverted(line_of("pos18,nE,nW,crc3:0xB", 74565)));
  EXPECT_THAT(crc(bits, {}, "pos18,nE,nW,crc3:0xB"), fails(1, "unsure"));
  const Outcome sure = crc(hex_of(inverted(line_of(format32, position32))), {}, format32);
  EXPECT_THAT(sure.err, Not(HasSubstr("unsure")));
}

TEST(CrcReadVariants, BufferWithoutAnyFrame_NamesNone) {
  for (const char* const text : {"FF FF FF FF FF FF FF FF FF FF FF", "00 00 00 00 00 00 00 00 00",
                                 "12 34 56 78 9A BC DE F0 12 34 56 78 9A"}) {
    EXPECT_THAT(crc(text, {}, format32), fails(1, Not(HasSubstr("try ")))) << text;
  }
}

TEST(CrcReadVariants, Payload_HasNoStartAndNoStop) {
  const std::string payload = frame_of(format18, 74565).substr(2);
  const Outcome outcome =
      ok(crc(hex_of(std::string(32 - payload.size(), '0') + payload), {"--payload"}));
  EXPECT_THAT(outcome.out, AllOf(Not(HasSubstr("START")), Not(HasSubstr("CDS")),
                                 Not(HasSubstr("STOP")), HasSubstr("74565")));
  EXPECT_THAT(outcome.err, Not(HasSubstr("leading ones")));
}

// ---- decode --words

class DecodeWords : public testing::Test {
 protected:
  static Outcome words(const std::string& file, const Words& more = {},
                       const std::string& format = "pos26,nE,nW,crc6") {
    return run(Words{"decode", "--words", file, "-f", format, "--to", "csv"} + more);
  }
  static std::string word(std::uint64_t position, const std::string& format = "pos26,nE,nW,crc6") {
    return hex_of(line_of(format, position, 20, 9));
  }

  Folder folder;
};

TEST_F(DecodeWords, LogOfWords_HasTheColumnsOfDecode) {
  const std::string file = folder.file("log.txt", "# a log\n\n" + word(1000) + "\n" + word(1001) +
                                                      "  # the second\n" + word(1002) + "\n");
  const Outcome outcome = ok(words(file));
  const auto rows = rows_of(outcome.out);
  ASSERT_EQ(rows.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(rows[i].at("cycle"), std::to_string(i));
    EXPECT_EQ(rows[i].at("time_ns"), "");
    EXPECT_EQ(rows[i].at("status"), "ok");
    EXPECT_EQ(rows[i].at("position"), std::to_string(1000 + i));
    EXPECT_EQ(rows[i].at("nE"), "1");
    EXPECT_EQ(rows[i].at("crc_ok"), "1");
    EXPECT_EQ(rows[i].at("line_delay_ns"), "");
    EXPECT_EQ(rows[i].at("limits"), "");
    EXPECT_THAT(rows[i].at("raw"), testing::StartsWith("0x"));
  }
  const std::string capture = folder.path("line.vcd");
  run_ok("simulate -f resolute-26 --cycles 2 -o {}", capture);
  const Outcome decoded = run("decode {} -f pos26,nE,nW,crc6 --to csv", capture);
  EXPECT_EQ(outcome.out.substr(0, outcome.out.find('\n')),
            decoded.out.substr(0, decoded.out.find('\n')));
}

TEST_F(DecodeWords, RawOfDecode_GivesThePositionsOfDecode) {
  const std::string capture = folder.path("line.vcd");
  run_ok("simulate -f resolute-26 --cycles 50 --motion ramp --fault flip:0.1 --fault nW:0.1 -o {}",
         capture);
  const Outcome decoded = run("decode {} -f pos26,nE,nW,crc6 --to csv", capture);
  const Outcome raw = run("decode {} -f pos26,nE,nW,crc6 --to csv --columns cycle,raw", capture);
  std::string log = raw.out.substr(raw.out.find('\n') + 1);
  std::replace(log.begin(), log.end(), ',', '\t');
  const auto expected = rows_of(decoded.out);
  const auto read = rows_of(words(folder.file("raw.txt", log), {"--first-bit", "-1"}).out);
  ASSERT_EQ(read.size(), expected.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    for (const char* const name : {"status", "position", "nE", "nW", "crc_ok", "raw"}) {
      EXPECT_EQ(read[i].at(name), expected[i].at(name)) << i << " " << name;
    }
  }
}

TEST_F(DecodeWords, TimeInFront_IsTheTimeOfTheRow) {
  std::string log;
  for (unsigned i = 0; i < 10; ++i)
    log += fmt::format("{}us {}\n", 100 + 50 * i, word(1000 + i * 8));
  const std::string file = folder.file("log.txt", log);
  const auto rows = rows_of(words(file, {"--velocity"}).out);
  ASSERT_EQ(rows.size(), 10U);
  EXPECT_EQ(rows[1].at("time_ns"), "150000");
  EXPECT_EQ(rows[1].at("velocity_counts_s"), "160000");
  const auto some = rows_of(words(file, {"--since", "190us", "--until", "300us"}).out);
  ASSERT_EQ(some.size(), 3U);
  EXPECT_EQ(some[0].at("cycle"), "2");
  run_ok("decode --words {} -f pos26,nE,nW,crc6 --to vcd", file);
}

TEST_F(DecodeWords, NumberInFront_IsNoPartOfTheWord) {
  for (const char* const separator : {" ", ": ", ", ", "\t", "; ", ","}) {
    std::string log;
    for (unsigned i = 8; i < 13; ++i) log += fmt::format("{}{}{}\n", i, separator, word(1000U + i));
    const auto rows = rows_of(words(folder.file("log.txt", log)).out);
    ASSERT_EQ(rows.size(), 5U) << separator;
    for (std::size_t i = 0; i < 5; ++i) {
      EXPECT_EQ(rows[i].at("position"), std::to_string(1008 + i)) << separator;
      EXPECT_EQ(rows[i].at("time_ns"), "");
    }
  }
  // Two digits of a byte each, numbers of two digits: they may be bytes.
  for (const char* const separator : {" ", ": "}) {
    std::string log;
    for (unsigned i = 10; i < 30; ++i) {
      std::string spaced;
      const std::string digits = word(1000U + i);
      for (std::size_t k = 0; k < digits.size(); k += 2) spaced += digits.substr(k, 2) + " ";
      log += fmt::format("{}{}{}\n", i, separator, spaced);
    }
    const Outcome outcome = words(folder.file("log.txt", log));
    if (std::string(separator) == " ") {
      EXPECT_EQ(outcome.status, 3);
      EXPECT_THAT(outcome.err, HasSubstr("write '10: '"));
    } else {
      EXPECT_EQ(rows_of(outcome.out).at(3).at("position"), "1013");
    }
  }
}

TEST_F(DecodeWords, VariantOfTheWords_IsNamedOnceAndSure) {
  std::string log;
  for (std::uint64_t i = 0; i < 20; ++i) {
    const std::string payload = frame_of("pos26,nE,nW,crc6", 70'000 + 91 * i).substr(2);
    log += hex_of(std::string(64 - payload.size(), '0') + payload) + "\n";
  }
  const std::string file = folder.file("log.txt", log);
  const Outcome outcome = words(file);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("--payload"), Not(HasSubstr("unsure"))));
  EXPECT_EQ(rows_of(ok(words(file, {"--payload", "--fail-on", "any"})).out).at(19).at("position"),
            "71729");
}

TEST_F(DecodeWords, OptionsOfDecode_WorkOnWords) {
  std::string bad = word(1005);
  bad[bad.size() - 8] = bad[bad.size() - 8] == '0' ? '1' : '0';
  const std::string file = folder.file("log.txt", word(1000) + "\n" + bad + "\n");
  EXPECT_EQ(words(file).status, 0);
  EXPECT_EQ(words(file, {"--fail-on", "any"}).status, 1);
  EXPECT_EQ(rows_of(words(file, {"--only-errors"}).out).size(), 1U);
  EXPECT_EQ(words(file, {"--columns", "position"}).out, "position\n1000\n\"\"\n");
  const std::string rows = folder.path("rows.jsonl");
  run_ok("decode --words {} -f pos26,nE,nW,crc6 -o {}", file, rows);
  EXPECT_THAT(content_of(rows), testing::StartsWith("{\"cycle\":0,\"time_ns\":null,"));
  EXPECT_EQ(
      run(Words("decode --words - -f pos26,nE,nW,crc6 --to csv --columns position"), file).out,
      "position\n1000\n\"\"\n");
}

TEST_F(DecodeWords, FormatThatIsNotGiven_IsIdentified) {
  std::string log;
  for (std::uint64_t i = 0; i < 400; ++i) {
    log += hex_of(line_of("pos26,nE,nW,crc6", 1'000'000 + 137 * i, 20, 9)) + "\n";
  }
  const Outcome outcome = run_ok("decode --words {} --to csv", folder.file("log.txt", log));
  EXPECT_EQ(rows_of(outcome.out).at(399).at("position"), "1054663") << outcome.err;
  const Outcome structure = run("decode --words {} -f none --to csv", folder.path("log.txt"));
  EXPECT_EQ(rows_of(structure.out).at(0).at("status"), "unchecked");
}

TEST_F(DecodeWords, WrongLine_IsNamedWithWhatToDo) {
  const std::string good = word(1000);
  const std::vector<std::pair<std::string, const char*>> logs{
      {good + "\nhello\n", ":2:"},
      {good + "\n" + good + "\n" + good + "x\n", ":3:"},
      {"5us " + good + "\n4us " + good + "\n", ":2:"},
      {"", "no word"},
      {"# nothing\n\n", "no word"},
      {std::string("\x1F\x8B\x08\x00", 4), "compressed"},
      {std::string("\xFD"
                   "7zXZ\0\0",
                   7),
       "compressed"},
  };
  for (const auto& [log, part] : logs) {
    const Outcome outcome = words(folder.file("log.txt", log));
    EXPECT_GE(outcome.status, 1) << part << outcome.out;
    EXPECT_THAT(outcome.err, AllOf(HasSubstr(part), HasSubstr("log.txt")));
  }
  EXPECT_EQ(words(folder.path("missing.txt")).status, 3);
}

TEST_F(DecodeWords, OptionThatNeedsALine_IsRefused) {
  const std::string file = folder.file("log.txt", word(1000) + "\n");
  for (const Words& option :
       {Words{"--ma", "MA"}, Words{"--invert-slo"}, Words{"--each"}, Words{"--resolution", "1ns"},
        Words{"--timeout", "adaptive"}, Words{"--since", "1us"}, Words{"--velocity"},
        Words{"--fail-on", "cycle_min"}, Words{"--fail-on", "marginal"}, Words{"--to", "vcd"},
        Words{"--no-compensation"}, Words{file}}) {
    const Outcome outcome = words(file, option);
    // 3: a line of the log has no time.
    EXPECT_GE(outcome.status, 2) << option[0] << outcome.out;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  const std::string capture = folder.path("line.vcd");
  run_ok("simulate -f resolute-26 --cycles 2 -o {}", capture);
  for (const Words& option :
       {Words{"--payload"}, Words{"--bit-order", "lsb"}, Words{"--invert"}, Words{"--bits", "3"}}) {
    EXPECT_EQ(run(Words{"decode", capture} + option).status, 2) << option[0];
  }
}

// ---- -o chooses the format

TEST_F(DecodeWords, EndingOfTheOutput_ChoosesTheFormatOfEveryVerbWithRows) {
  const std::string capture = folder.path("line.vcd");
  run_ok("simulate -f resolute-26 --cycles 60 --motion ramp -o {}", capture);
  const std::vector<Words> verbs{
      {"decode", capture, "-f", "resolute-26"},    {"identify", capture},
      {"explain", capture, "-f", "resolute-26"},   {"check", capture, "-f", "resolute-26"},
      {"registers", capture, "-f", "resolute-26"}, {"compare", capture, capture}};
  for (const Words& verb : verbs) {
    for (const char* const to : {"csv", "jsonl"}) {
      const std::string output = folder.path(std::string("rows.") + to);
      run(verb + Words{"-o", output});
      const std::string expected = folder.path("expected");
      run(verb + Words{"--to", to, "-o", expected});
      EXPECT_TRUE(content_of(output) == content_of(expected)) << verb[0] << to;
    }
    // --to wins, and any other ending is the table.
    run(verb + Words{"--to", "jsonl", "-o", folder.path("other.csv")});
    EXPECT_EQ(content_of(folder.path("other.csv")), content_of(folder.path("rows.jsonl")));
    run(verb + Words{"-o", folder.path("rows.txt")});
    run(verb + Words{"--to", "table", "-o", folder.path("table.csv")});
    EXPECT_EQ(content_of(folder.path("rows.txt")), content_of(folder.path("table.csv")));
  }
  run_ok("decode {} -f resolute-26 -o {}", capture, folder.path("r.h5"));
  EXPECT_THAT(content_of(folder.path("r.h5")), testing::StartsWith("MATLAB 7.3 MAT-file"));
  run_ok("decode {} -f resolute-26 -o {}", capture, folder.path("r.vcd"));
  EXPECT_THAT(content_of(folder.path("r.vcd")), HasSubstr("$var"));
  run_ok("crc -f {} 5 -o {}", format18, folder.path("f.jsonl"));
  EXPECT_THAT(content_of(folder.path("f.jsonl")), testing::StartsWith("{\"position\":5,"));
  // A table for the eye is not a CSV.
  EXPECT_THAT(run("crc -f {} 5 -o {}", format18, folder.path("f.csv")),
              fails(2, AllOf(HasSubstr("csv"), HasSubstr("--to"))));
}

// ---- compressions that are not read

TEST_F(DecodeWords, CompressionThatIsNotRead_IsNamed) {
  const std::vector<std::pair<std::string, std::string>> files{{std::string("\xFD"
                                                                            "7zXZ\0\0\4\xE6",
                                                                            8),
                                                                "xz"},
                                                               {"BZh91AY&SY\x01\x02", "bzip2"}};
  for (const auto& [bytes, name] : files) {
    for (const auto& ending : {"csv." + name, std::string("vcd"), std::string("dat")}) {
      const std::string file = folder.file("a." + ending, bytes);
      EXPECT_THAT(run("decode {}", file),
                  fails(3, AllOf(HasSubstr("this is " + name), HasSubstr("decompress"))));
      const Outcome raw = run("decode {} --raw-rate 10MHz --ma D0 --slo D1", file);
      EXPECT_THAT(raw.err, HasSubstr("this is " + name)) << ending;
    }
  }
}

}  // namespace biss::verbs::words_test
