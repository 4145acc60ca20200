#include "capture/open.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "capture/test_capture.hpp"
#include "capture/test_compressed.hpp"
#include "capture/test_samples.hpp"

namespace biss::capture {
namespace open_test {

Read read_as(std::string_view text, std::string_view path, std::size_t block = one_block) {
  return read_all(open_capture(memory_bytes(text, block), path));
}

const std::string vcd = vcd_of_ma_and_slo("#0 1!\n");
const std::string csv = "time_ns,MA,SLO\n0,1,\n";

TEST(Open, Content_DecidesWhateverTheExtension) {
  for (const char* path : {"a.vcd", "a.csv", "a.txt", "a", "-"}) {
    for (const std::size_t block : {std::size_t{1}, one_block}) {
      EXPECT_EQ(read_as(vcd, path, block).edges.size(), 1U) << path;
      EXPECT_EQ(read_as(csv, path, block).edges.size(), 1U) << path;
      EXPECT_EQ(read_as("\n\n# x\n\n \"Time [s]\",MA\n0,1\n", path, block).edges.size(), 1U)
          << path;
    }
  }
}

TEST(Open, UnknownContent_IsJudgedByTheExtension) {
  const Read as_vcd = read_as("hello world\n", "a.VCD");
  EXPECT_EQ(as_vcd.cause(), CaptureCause::malformed);
  EXPECT_NE(std::string(as_vcd.error->expected).find("VCD"), std::string::npos);
  const Read as_csv = read_as("hello world\n", "a.csv");
  EXPECT_EQ(as_csv.cause(), CaptureCause::malformed);
  EXPECT_NE(std::string(as_csv.error->expected).find("time_ns"), std::string::npos);
  EXPECT_EQ(read_as("hello world\n", "a.txt").cause(), CaptureCause::unknown_format);
}

TEST(Open, Empty_IsSaidWhateverTheExtension) {
  for (const char* path : {"a.vcd", "a.csv", "a.txt", "-"}) {
    EXPECT_EQ(read_as("", path).cause(), CaptureCause::empty) << path;
    EXPECT_EQ(read_as(" \n\n", path).cause(), CaptureCause::empty) << path;
  }
}

TEST(Open, FormatsOfOthers_AreNamed) {
  EXPECT_EQ(read_as("\x1F\x8B\x08", "a.vcd").cause(), CaptureCause::truncated);
  EXPECT_EQ(read_as("\xFF\xFE$", "a.vcd").cause(), CaptureCause::unknown_format);
  const Read sal = read_as(zip_of({{"meta.json", "{}"}}), "a.sal");
  ASSERT_EQ(sal.cause(), CaptureCause::unknown_format);
  EXPECT_NE(std::string(sal.error->expected).find("in Logic 2, export"), std::string::npos);
}

TEST(Open, Session_IsKnownWhateverTheExtension) {
  const std::string session = zip_of(session_of({"\3\2"}));
  for (const char* path : {"a.sr", "a.zip", "a.vcd", "a.bin", "-"}) {
    for (const std::size_t block : {std::size_t{1}, one_block}) {
      EXPECT_EQ(read_as(session, path, block).edges.size(), 3U) << path;
    }
  }
  EXPECT_EQ(read_as("no archive", "a.sr").cause(), CaptureCause::damaged);
}

TEST(Open, RawSamples_NeedALayout) {
  const OpenOptions options{.raw = RawLayout{megahertz(1), 1, {{"MA", 0}}}};
  const auto read_with = [&](std::string_view bytes, std::string_view path) {
    return read_all(open_capture(memory_bytes(bytes), path, options));
  };
  for (const std::string& bytes : {std::string("\1\0", 2), std::string("PK\x03\x04"), vcd, csv,
                                   std::string("\xFF\xFE"), std::string(" \t\n")}) {
    for (const char* path : {"a.bin", "a.RAW"}) {
      EXPECT_EQ(read_with(bytes, path).lines.size(), 1U) << path;
      EXPECT_FALSE(read_with(bytes, path).error) << path;
    }
  }
  EXPECT_EQ(read_with("\xFF\xFE", "a.samples").edges.size(), 2U);
  EXPECT_EQ(read_with(csv, "a.csv").lines.size(), 2U);
  EXPECT_EQ(read_with(vcd, "-").lines.size(), 2U);
  EXPECT_EQ(read_with("<SALEAE>\x01", "a.bin").cause(), CaptureCause::truncated);
  EXPECT_EQ(read_with("hello", "a.csv").cause(), CaptureCause::malformed);
  EXPECT_TRUE(open_capture(memory_bytes("\1"), "a.bin", options).value()->is_raw());
  EXPECT_FALSE(open_capture(memory_bytes(csv), "a.csv", options).value()->is_raw());
  const Read without = read_as("\1\2\3", "a.bin");
  ASSERT_EQ(without.cause(), CaptureCause::layout_missing);
  EXPECT_NE(std::string(without.error->expected).find("rate"), std::string::npos);
}

TEST(Open, CompressionThatIsNotRead_IsNamedInEachContainer) {
  const std::vector<std::pair<std::string, std::string>> files{
      {std::string("\xFD\x37zXZ\0\0\4", 8), "this is xz"},
      {"BZh91AY&SY\1", "this is bzip2"},
      {"BZh9\x17rE8P\x90", "this is bzip2"},
      {"\x04\x22M\x18\x64", "this is LZ4"},
      {"LZIP\1\x0C", "this is lzip"},
      {"7z\xBC\xAF\x27\x1C", "this is 7z"}};
  for (const auto& [bytes, name] : files) {
    for (const auto& [text, path] : {std::pair(bytes, "a.vcd"),
                                     {bytes, "a.sr"},
                                     {bytes, "-"},
                                     {gzip_of(bytes), "a.csv.gz"},
                                     {zstd_of(bytes), "a.zst"}}) {
      const Read read = read_as(text, path);
      ASSERT_EQ(read.cause(), CaptureCause::compression) << name << path;
      EXPECT_NE(std::string(read.error->expected).find(name), std::string::npos) << path;
      EXPECT_NE(capture_error_text(*read.error, path).find("decompress"), std::string::npos);
    }
  }
  EXPECT_EQ(read_as("BZh,MA\n1,0\n", "a.txt").cause(), CaptureCause::unknown_format);
}

TEST(Open, BlanksBeyondMeasure_EndInAnError) {
  EXPECT_EQ(read_as(std::string(1'000'000, ' '), "a.txt").cause(), CaptureCause::unknown_format);
  EXPECT_EQ(read_as(std::string(1'000'000, '\n') + vcd, "a.vcd").edges.size(), 1U);
}

TEST(Open, PathsThatCannotBeRead_KeepTheirCause) {
  EXPECT_EQ(open_capture("no/such/file.vcd").error().cause, CaptureCause::cannot_open);
  EXPECT_EQ(open_capture(std::filesystem::temp_directory_path().string()).error().cause,
            CaptureCause::is_directory);
}

TEST(ErrorText, PlaceInTheText_IsNamed) {
  const Read read = read_as(vcd + "oops\n", "run.vcd");
  ASSERT_TRUE(read.error);
  EXPECT_EQ(
      capture_error_text(*read.error, "run.vcd"),
      "run.vcd:8:1: does not follow the format, expected a value change, a time or a word such "
      "as $dumpvars; correct this place or export the capture again");
}

TEST(ErrorText, EveryCause_IsOneLineWithAdvice) {
  for (int cause = 0; cause <= static_cast<int>(CaptureCause::truncated); ++cause) {
    const std::string text =
        capture_error_text({.cause = static_cast<CaptureCause>(cause)}, "a\nb.vcd");
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    EXPECT_EQ(text.rfind("a?b.vcd: ", 0), 0U) << text;
    EXPECT_NE(text.find("; "), std::string::npos) << text;
  }
  EXPECT_EQ(capture_error_text({.cause = CaptureCause::empty}, "-"),
            "standard input: is empty; export the capture again");
}

}  // namespace open_test
}  // namespace biss::capture
