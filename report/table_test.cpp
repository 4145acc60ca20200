#include "report/table.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <locale>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/common/german_punctuation.hpp"
#include "tests/common/random.hpp"

namespace biss::report {
namespace table_test {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t largest = std::numeric_limits<std::uint64_t>::max();

std::vector<Column> decode_columns() {
  return {
      {.name = "cycle", .kind = Kind::unsigned_integer},
      {.name = "time_ns",
       .kind = Kind::nanoseconds,
       .heading = "time",
       .unit = "us",
       .shift = 3,
       .places = 3},
      {.name = "status", .kind = Kind::text, .role = Role::status},
      {.name = "position", .kind = Kind::unsigned_integer},
      {.name = "nE", .kind = Kind::flag},
      {.name = "nW", .kind = Kind::flag},
      {.name = "crc_ok", .kind = Kind::flag, .heading = "CRC"},
      {.name = "line_delay_ns",
       .kind = Kind::nanoseconds,
       .heading = "delay",
       .unit = "ns",
       .places = 1},
      {.name = "ack_ns", .kind = Kind::nanoseconds, .heading = "ACK", .unit = "ns", .places = 0},
      {.name = "clock_hz",
       .kind = Kind::unsigned_integer,
       .heading = "clock",
       .unit = "MHz",
       .shift = 6,
       .places = 3},
      {.name = "raw", .kind = Kind::bits},
  };
}

std::string write(Format format, const std::vector<Column>& columns,
                  const std::vector<std::vector<Cell>>& rows, TableOptions options = {}) {
  StringSink sink;
  const auto writer = make_table_writer(format, columns, sink, options);
  for (const auto& row : rows) EXPECT_TRUE(writer->row(row));
  EXPECT_TRUE(writer->finish());
  return sink.text();
}

std::string json_of(const Cell& cell) {
  return write(Format::jsonl, {{.name = "v", .kind = cell.kind()}}, {{cell}});
}

std::string csv_of(const Cell& cell) {
  const std::string text = write(Format::csv, {{.name = "v", .kind = cell.kind()}}, {{cell}});
  return text.substr(2);
}

const std::vector<std::uint8_t> raw_bytes = {0x81, 0x23, 0x45, 0x67, 0x80};

std::vector<std::vector<Cell>> decode_rows() {
  const BitView raw(raw_bytes, 0, 37);
  return {
      {0U, picoseconds(12'500'000), "ok", 458U, true, true, true, picoseconds(112'250),
       nanoseconds(4'500), megahertz(1), raw},
      {1U,
       picoseconds(112'500'125),
       "crc",
       {},
       {},
       {},
       false,
       picoseconds(112'000),
       nanoseconds(4'500),
       hertz(999'950),
       raw},
      {2U,
       picoseconds(212'500'000),
       "no_response",
       {},
       {},
       {},
       {},
       {},
       {},
       megahertz(1),
       BitView()},
  };
}

TEST(FormatNames, EveryName_IsFoundAndAnotherIsNot) {
  EXPECT_EQ(format_by_name("table"), Format::table);
  EXPECT_EQ(format_by_name("csv"), Format::csv);
  EXPECT_EQ(format_by_name("jsonl"), Format::jsonl);
  EXPECT_EQ(format_by_name("vcd"), Format::vcd);
  EXPECT_EQ(format_by_name("hdf5"), Format::hdf5);
  EXPECT_EQ(format_by_name("json"), std::nullopt);
  EXPECT_EQ(format_by_name(""), std::nullopt);
}

TEST(Csv, RowsOfDecode_AreExact) {
  EXPECT_EQ(write(Format::csv, decode_columns(), decode_rows()),
            "cycle,time_ns,status,position,nE,nW,crc_ok,line_delay_ns,ack_ns,clock_hz,raw\n"
            "0,12500,ok,458,1,1,1,112.25,4500,1000000,0x102468ACF0\n"
            "1,112500.125,crc,,,,0,112,4500,999950,0x102468ACF0\n"
            "2,212500,no_response,,,,,,,1000000,\n");
}

TEST(Csv, NoRows_HasTheHeaderAlone) {
  EXPECT_EQ(write(Format::csv, {{.name = "a"}, {.name = "b,c"}}, {}), "a,\"b,c\"\n");
}

TEST(Csv, HostileText_IsQuoted) {
  EXPECT_EQ(csv_of("a,b"), "\"a,b\"\n");
  EXPECT_EQ(csv_of("say \"no\""), "\"say \"\"no\"\"\"\n");
  EXPECT_EQ(csv_of("two\nlines"), "\"two\nlines\"\n");
  EXPECT_EQ(csv_of("return\r"), "\"return\r\"\n");
  EXPECT_EQ(csv_of("plain text; 1"), "plain text; 1\n");
  EXPECT_EQ(csv_of("\xff\xfe"), "\xff\xfe\n");
}

TEST(Csv, OneAbsentColumn_IsStillALineOfItsOwn) {
  EXPECT_EQ(csv_of(Cell()), "\"\"\n");
  EXPECT_EQ(csv_of(""), "\"\"\n");
}

TEST(Csv, ExtremeIntegers_AreDecimal) {
  EXPECT_EQ(csv_of(largest), "18446744073709551615\n");
  EXPECT_EQ(csv_of(std::numeric_limits<std::int64_t>::min()), "-9223372036854775808\n");
}

TEST(Csv, ShortRow_IsFilledWithAbsentCells) {
  EXPECT_EQ(write(Format::csv, {{.name = "a"}, {.name = "b"}, {.name = "c"}}, {{"x"}}),
            "a,b,c\nx,,\n");
}

TEST(Jsonl, RowsOfDecode_AreExact) {
  EXPECT_EQ(write(Format::jsonl, decode_columns(), decode_rows()),
            R"({"cycle":0,"time_ns":12500,"status":"ok","position":458,"nE":1,"nW":1,"crc_ok":1,)"
            R"("line_delay_ns":112.25,"ack_ns":4500,"clock_hz":1000000,"raw":"0x102468ACF0"})"
            "\n"
            R"({"cycle":1,"time_ns":112500.125,"status":"crc","position":null,"nE":null,)"
            R"("nW":null,"crc_ok":0,"line_delay_ns":112,"ack_ns":4500,"clock_hz":999950,)"
            R"("raw":"0x102468ACF0"})"
            "\n"
            R"({"cycle":2,"time_ns":212500,"status":"no_response","position":null,"nE":null,)"
            R"("nW":null,"crc_ok":null,"line_delay_ns":null,"ack_ns":null,"clock_hz":1000000,)"
            R"("raw":""})"
            "\n");
}

TEST(Jsonl, NoRows_IsEmpty) { EXPECT_EQ(write(Format::jsonl, decode_columns(), {}), ""); }

TEST(Jsonl, IntegersAbove2To53_AreStrings) {
  constexpr std::uint64_t limit = std::uint64_t{1} << 53U;
  EXPECT_EQ(json_of(limit), "{\"v\":9007199254740992}\n");
  EXPECT_EQ(json_of(limit + 1), "{\"v\":\"9007199254740993\"}\n");
  EXPECT_EQ(json_of(largest), "{\"v\":\"18446744073709551615\"}\n");
  EXPECT_EQ(json_of(-static_cast<std::int64_t>(limit)), "{\"v\":-9007199254740992}\n");
  EXPECT_EQ(json_of(-static_cast<std::int64_t>(limit) - 1), "{\"v\":\"-9007199254740993\"}\n");
  EXPECT_EQ(json_of(std::numeric_limits<std::int64_t>::min()),
            "{\"v\":\"-9223372036854775808\"}\n");
  EXPECT_EQ(json_of(picoseconds(std::numeric_limits<std::int64_t>::max())),
            "{\"v\":\"9223372036854775.807\"}\n");
}

TEST(Jsonl, HostileKey_IsEscaped) {
  const std::string text = write(Format::jsonl, {{.name = "a\"b\n"}}, {{"x"}});
  EXPECT_EQ(Json::parse(text).begin().key(), "a\"b\n");
}

TEST(Jsonl, InvalidUtf8_IsReplacedAndParses) {
  EXPECT_EQ(json_of("a\xff"), "{\"v\":\"a\uFFFD\"}\n");
  EXPECT_EQ(Json::parse(json_of("\xED\xA0\x80"))["v"], "\uFFFD\uFFFD\uFFFD");
}

TEST(Jsonl, EveryByteAlone_ParsesAsOneLine) {
  for (unsigned byte = 0; byte < 256; ++byte) {
    const std::string text(1, static_cast<char>(byte));
    const std::string line = json_of(text);
    ASSERT_EQ(line.find('\n'), line.size() - 1) << byte;
    const Json parsed = Json::parse(line);
    ASSERT_EQ(parsed["v"].get<std::string>(), byte < 0x80 ? text : "\uFFFD") << byte;
  }
}

// The writer prints the same as the library for the same values.
TEST(Jsonl, RandomRows_EqualTheLibrarysText) {
  std::mt19937_64 random = test::random_of();
  const std::vector<std::string> pieces = {"a",    "\"",   "\\", "\n", "\t", "\r", "\b",   "\f",
                                           "\x01", "\x1f", "µ",  "€",  "😀",  "/",  "\x7f", " "};
  const std::vector<Column> columns = {{.name = "u", .kind = Kind::unsigned_integer},
                                       {.name = "s", .kind = Kind::signed_integer},
                                       {.name = "f", .kind = Kind::flag},
                                       {.name = "t", .kind = Kind::text},
                                       {.name = "x", .kind = Kind::unsigned_integer}};
  for (int i = 0; i < 5'000; ++i) {
    const std::uint64_t u = random() >> (11 + random() % 53);
    const auto s = static_cast<std::int64_t>(random()) >> (11 + random() % 53);
    const bool f = (random() & 1U) != 0;
    std::string t;
    for (auto n = random() % 8; n > 0; --n) t += pieces[random() % pieces.size()];
    Json expected;
    expected["u"] = u;
    expected["s"] = s;
    expected["f"] = f ? 1 : 0;
    expected["t"] = t;
    expected["x"] = nullptr;
    ASSERT_EQ(write(Format::jsonl, columns, {{u, s, f, t, Cell()}}), expected.dump() + "\n");
  }
}

TEST(RealCells, ComeBackAsTheSameDouble) {
  const std::vector<Column> columns = {{.name = "r", .kind = Kind::real}};
  for (const double value : {0.0, 1.0, 0.1, -2.5, 1.0408340855860843e-17, 2.3e-308, 1.7e308}) {
    const std::string line = write(Format::jsonl, columns, {{value}});
    EXPECT_EQ(Json::parse(line).at("r").get<double>(), value) << line;
    EXPECT_EQ(std::stod(write(Format::csv, columns, {{value}}).substr(2)), value);
  }
  EXPECT_EQ(write(Format::csv, columns, {{1.25}}), "r\n1.25\n");
  EXPECT_EQ(write(Format::table, columns, {{1e-9}}), "    r\n─────\n1e-09\n");
}

TEST(RealCells, NotFinite_AreAbsent) {
  const std::vector<Column> columns = {{.name = "r", .kind = Kind::real}};
  for (const double value : {std::numeric_limits<double>::infinity(), std::nan("")}) {
    EXPECT_EQ(write(Format::jsonl, columns, {{value}}), "{\"r\":null}\n");
    EXPECT_EQ(write(Format::csv, columns, {{value}}), "r\n\"\"\n");
    EXPECT_EQ(write(Format::table, columns, {{value}}), "r\n─\n-\n");
  }
}

TEST(EyeTable, RowsOfDecode_AreAlignedAndRounded) {
  EXPECT_EQ(write(Format::table, decode_columns(), decode_rows()),
            "cycle     time  status       position  nE  nW  CRC  delay   ACK  clock  raw\n"
            "            us                                         ns    ns    MHz\n"
            "─────  ───────  ───────────  ────────  ──  ──  ───  ─────  ────  ─────  ────────────\n"
            "    0   12.500  ok                458   1   1    1  112.3  4500  1.000  0x102468ACF0\n"
            "    1  112.500  crc                 -   -   -    0  112.0  4500  1.000  0x102468ACF0\n"
            "    2  212.500  no_response         -   -   -    -      -     -  1.000  -\n");
}

TEST(EyeTable, NoUnits_HasOneLineOfHeadings) {
  EXPECT_EQ(write(Format::table, {{.name = "a"}, {.name = "n", .kind = Kind::flag}}, {{"x", true}}),
            "a  n\n─  ─\nx  1\n");
}

TEST(EyeTable, NoRows_HasTheHeadAlone) {
  EXPECT_EQ(write(Format::table, {{.name = "long"}, {.name = "b"}}, {}), "long  b\n────  ─\n");
}

TEST(EyeTable, HostileText_StaysOnItsLineAndInItsColumn) {
  EXPECT_EQ(write(Format::table, {{.name = "text"}, {.name = "n", .kind = Kind::flag}},
                  {{"µ編", true}, {"a\nb\x1b", false}, {"\xff", true}, {"", true}}),
            "text  n\n"
            "────  ─\n"
            "µ編   1\n"
            "a\uFFFDb\uFFFD  0\n"
            "\uFFFD     1\n"
            "-     1\n");
}

TEST(EyeTable, NumbersOnATerminal_AreExactToTheLastDigit) {
  EXPECT_EQ(write(Format::table, {{.name = "v", .kind = Kind::unsigned_integer}},
                  {{largest}, {std::uint64_t{1} << 63U}}),
            "                   v\n"
            "────────────────────\n"
            "18446744073709551615\n"
            " 9223372036854775808\n");
}

TEST(EyeTable, MoreRowsThanMeasured_StreamAndWidenFromThere) {
  const std::vector<Column> columns = {{.name = "n", .kind = Kind::unsigned_integer},
                                       {.name = "t"}};
  const std::string text =
      write(Format::table, columns, {{1U, "a"}, {20U, "b"}, {3U, "c"}, {4000U, "d"}, {5U, "e"}},
            {.rows_measured = 2});
  EXPECT_EQ(text, " n  t\n──  ─\n 1  a\n20  b\n 3  c\n4000  d\n   5  e\n");
}

TEST(EyeTable, Colour_MarksOnlyTheStatusThatIsNotOk) {
  const std::vector<Column> columns = {{.name = "status", .role = Role::status}, {.name = "t"}};
  const std::vector<std::vector<Cell>> rows = {{"ok", "crc"}, {"crc", "ok"}};
  EXPECT_EQ(write(Format::table, columns, rows).find('\x1b'), std::string::npos);
  EXPECT_EQ(write(Format::table, columns, rows, {.colour = true}),
            "status  t\n"
            "\x1b[2m──────  ───\x1b[0m\n"
            "ok      crc\n"
            "\x1b[33mcrc   \x1b[0m  ok\n");
}

class FailingSink final : public TextSink {
 public:
  explicit FailingSink(std::size_t bytes) : left_(bytes) {}
  bool write(std::string_view text) override {
    ++calls;
    if (text.size() > left_) failed_ = true;
    if (!failed_) left_ -= text.size();
    return !failed_;
  }
  int calls = 0;

 private:
  std::size_t left_;
  bool failed_ = false;
};

TEST(EveryFormat, SinkThatFails_StopsTheRowsAndFailsTheFinish) {
  for (const Format format : {Format::table, Format::csv, Format::jsonl}) {
    FailingSink sink(100'000);
    const auto writer = make_table_writer(format, decode_columns(), sink);
    const auto rows = decode_rows();
    int taken = 0;
    while (taken < 100'000 && writer->row(rows[0])) ++taken;
    EXPECT_GT(taken, 500);
    EXPECT_LT(taken, 5'000);
    EXPECT_FALSE(writer->finish());
    EXPECT_LE(sink.calls, 3);
  }
}

TEST(EveryFormat, SinkThatFailsAtOnce_FailsTheFinish) {
  for (const Format format : {Format::table, Format::csv, Format::jsonl, Format::vcd}) {
    FailingSink sink(3);
    const auto writer = make_table_writer(format, decode_columns(), sink);
    writer->row(decode_rows()[0]);
    EXPECT_FALSE(writer->finish());
  }
}

TEST(EveryFormat, LocaleWithCommaAndGroups_ChangesNothing) {
  for (const Format format : {Format::table, Format::csv, Format::jsonl, Format::vcd}) {
    const std::string before = write(format, decode_columns(), decode_rows());
    const std::locale old = std::locale::global(std::locale({}, new test::GermanPunctuation));
    const std::string after = write(format, decode_columns(), decode_rows());
    std::locale::global(old);
    EXPECT_EQ(after, before);
  }
}

TEST(Vcd, RowsOfDecode_AreVariablesThatChange) {
  std::vector<Column> columns = decode_columns();
  columns[3].bits = 26;
  columns[10].bits = 37;
  EXPECT_EQ(write(Format::vcd, columns, decode_rows()),
            "$timescale 1 ps $end\n"
            "$scope module decode $end\n"
            "$var event 1 \" request $end\n"
            "$var integer 65 # cycle $end\n"
            "$var string 1 % status $end\n"
            "$var integer 27 & position $end\n"
            "$var wire 1 ' nE $end\n"
            "$var wire 1 ( nW $end\n"
            "$var wire 1 ) crc_ok $end\n"
            "$var real 64 * line_delay_ns $end\n"
            "$var real 64 + ack_ns $end\n"
            "$var integer 65 , clock_hz $end\n"
            "$var wire 37 - raw $end\n"
            "$upscope $end\n$enddefinitions $end\n"
            "$dumpvars\nbx #\ns %\nbx &\nx'\nx(\nx)\nrnan *\nrnan +\nbx ,\nbx -\n$end\n"
            "#12500000\n1\"\nb0 #\nsok %\nb111001010 &\n1'\n1(\n1)\nr112.25 *\nr4500 +\n"
            "b11110100001001000000 ,\nb1000000100100011010001010110011110000 -\n"
            "#112500125\n1\"\nb1 #\nscrc %\nbx &\nx'\nx(\n0)\nr112 *\n"
            "b11110100001000001110 ,\n"
            "#212500000\n1\"\nb10 #\nsno_response %\nx)\nrnan *\nrnan +\n"
            "b11110100001001000000 ,\nbx -\n");
}

TEST(Vcd, SignedNumbersAndText_KeepTheirValue) {
  const std::vector<Column> columns = {{.name = "t", .kind = Kind::nanoseconds},
                                       {.name = "s", .kind = Kind::signed_integer, .bits = 4},
                                       {.name = "r", .kind = Kind::real},
                                       {.name = "text", .kind = Kind::text}};
  const std::string text = write(Format::vcd, columns,
                                 {{picoseconds(1), std::int64_t{-2}, -0.25, "a b\\"},
                                  {picoseconds(2), std::int64_t{5}, std::nan(""), "µ"}});
  EXPECT_EQ(text.substr(text.find("#1\n")),
            "#1\n1\"\nb1110 $\nr-0.25 %\nsa\\040b\\134 &\n"
            "#2\n1\"\nb0101 $\nrnan %\ns\\302\\265 &\n");
}

TEST(Vcd, ManyColumns_HaveNamesOfTheirOwn) {
  std::vector<Column> columns;
  for (int i = 0; i < 300; ++i) columns.push_back({.name = std::to_string(i), .kind = Kind::flag});
  const std::string text = write(Format::vcd, columns, {});
  std::set<std::string> ids;
  std::istringstream words(text.substr(0, text.find("$upscope")));
  std::string word;
  while (words >> word) {
    if (word != "$var") continue;
    words >> word >> word >> word;
    EXPECT_TRUE(ids.insert(word).second) << word;
  }
  EXPECT_EQ(ids.size(), 301U);
}

TEST(Cells, OptionalValue_IsAbsentOrTheValue) {
  EXPECT_EQ(Cell(std::optional<std::uint64_t>()).kind(), Kind::absent);
  EXPECT_EQ(Cell(std::optional<bool>(true)).kind(), Kind::flag);
  EXPECT_EQ(Cell(std::optional<Picoseconds>(nanoseconds(3))).time(), nanoseconds(3));
}

TEST(Table, ANarrowTerminal_ShowsFewerColumnsAndSaysWhich) {
  const std::vector<Column> columns{{.name = "cycle", .kind = Kind::unsigned_integer},
                                    {.name = "status", .kind = Kind::text},
                                    {.name = "raw", .kind = Kind::bits},
                                    {.name = "delay", .kind = Kind::unsigned_integer},
                                    {.name = "safety", .kind = Kind::text}};
  const std::vector<std::vector<Cell>> rows{{7U, "ok", BitView(raw_bytes, 0, 32), 112U, Cell()}};
  std::vector<std::string> left_out;
  TableOptions options;
  options.on_left_out = [&](const std::vector<std::string>& names) { left_out = names; };
  const auto head = [&](std::size_t width) {
    left_out.clear();
    options.width = width;
    const std::string text = write(Format::table, columns, rows, options);
    return text.substr(0, text.find('\n'));
  };
  const std::string all = head(0);
  EXPECT_EQ(left_out, std::vector<std::string>{});
  EXPECT_EQ(head(all.size()), all);
  EXPECT_EQ(left_out, std::vector<std::string>{});
  EXPECT_EQ(head(all.size() - 1).find("safety"), std::string::npos);
  EXPECT_EQ(left_out, std::vector<std::string>{"safety"});
  EXPECT_EQ(head(21), "cycle  status  delay");
  EXPECT_EQ(left_out, (std::vector<std::string>{"raw", "safety"}));
  EXPECT_EQ(head(19), "cycle  status");
  EXPECT_EQ(head(1), "cycle");
  EXPECT_EQ(write(Format::csv, columns, {}, options), "cycle,status,raw,delay,safety\n");
}

}  // namespace table_test
}  // namespace biss::report
