#include "capture/compressed.hpp"

#include <gtest/gtest.h>
#include <zlib.h>
#include <zstd.h>

#include <random>
#include <string>
#include <utility>
#include <vector>

#include "capture/open.hpp"
#include "capture/test_capture.hpp"
#include "capture/test_compressed.hpp"
#include "capture/test_samples.hpp"

namespace biss::capture {
namespace compressed_test {

Read read_as(std::string_view text, std::string_view path, std::size_t block = one_block) {
  return read_all(open_capture(memory_bytes(text, block), path));
}

struct Text {
  std::string text;
  std::optional<CaptureError> error;
};

Text text_of(ByteSource& bytes, std::size_t block) {
  Text read;
  std::string buffer(block, '\0');
  for (;;) {
    const auto got = bytes.read(buffer);
    if (!got.ok()) read.error = got.error();
    if (!got.ok() || *got == 0) return read;
    read.text.append(buffer, 0, *got);
  }
}

Text decompressed_text(std::string_view bytes, std::size_t in_block = one_block,
                       std::size_t out_block = 10'000) {
  const auto source = decompressed(memory_bytes(bytes, in_block), compression_of(bytes));
  Text first = text_of(*source, out_block);
  // The end and the error are final.
  const auto again = source->read(std::span(first.text));
  EXPECT_EQ(again.ok(), !first.error);
  return first;
}

std::string random_text(std::mt19937_64& random, std::size_t size) {
  std::string text;
  while (text.size() < size) text += std::to_string(random() % 1'000) + "1!\n";
  text.resize(size);
  return text;
}

const std::vector<std::pair<const char*, std::string (*)(std::string_view)>> kinds{
    {"gzip", [](std::string_view text) { return gzip_of(text); }},
    {"zstd", [](std::string_view text) { return zstd_of(text); }}};

const std::string vcd = vcd_of_ma_and_slo("#0 1! 1\"\n#100 0!\n#200 1!\n#300\n");

TEST(Compressed, WrongChecksum_DeliversAllTextFirst) {
  std::mt19937_64 random(7'502);
  for (const auto& [name, compress] : kinds) {
    for (const std::size_t size : {100U, 300'000U}) {
      const std::string text = random_text(random, size);
      std::string bytes = compress(text);
      // The last four bytes are the checksum of zstd; those of gzip come before the length.
      bytes[bytes.size() - (std::string_view(name) == "gzip" ? 8 : 4)] ^= 1;
      for (const std::size_t in : {std::size_t{7}, one_block}) {
        const Text read = decompressed_text(bytes, in, 1'000'000);
        ASSERT_TRUE(read.error) << name;
        EXPECT_EQ(read.error->cause, CaptureCause::damaged);
        EXPECT_TRUE(read.text == text) << name << ' ' << size << ' ' << in;
      }
    }
  }
}

TEST(Compressed, EveryBlockSize_GivesTheTextBack) {
  std::mt19937_64 random(7'501);
  for (const auto& [name, compress] : kinds) {
    for (const std::size_t size : {0U, 1U, 1'000U, 300'000U}) {
      const std::string text = random_text(random, size);
      const std::string bytes = compress(text);
      for (const std::size_t in : {std::size_t{1}, std::size_t{7}, one_block}) {
        for (const std::size_t out : {std::size_t{1}, std::size_t{100}, std::size_t{70'000}}) {
          if (size > 1'000 && in == 1 && out == 1) continue;
          const Text read = decompressed_text(bytes, in, out);
          EXPECT_FALSE(read.error) << name;
          EXPECT_TRUE(read.text == text) << name << ' ' << size << ' ' << in << ' ' << out;
        }
      }
    }
  }
}

TEST(Compressed, MembersThatFollowEachOther_AreOneText) {
  for (const auto& [name, compress] : kinds) {
    const std::string bytes = compress("one ") + compress("") + compress("two");
    for (const std::size_t block : {std::size_t{1}, one_block}) {
      const Text read = decompressed_text(bytes, block);
      EXPECT_FALSE(read.error) << name;
      EXPECT_EQ(read.text, "one two") << name;
    }
  }
}

TEST(Compressed, ZerosAfterAGzipMember_AreIgnored) {
  const Text read = decompressed_text(gzip_of("one ") + std::string(1'000, '\0'));
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.text, "one ");
}

TEST(Compressed, SkippableFrameOfZstd_IsSkipped) {
  const std::string skipped = std::string("\x50*M\x18\3\0\0\0abc", 11);
  const Text read = decompressed_text(skipped + zstd_of("text") + skipped);
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.text, "text");
}

TEST(Compressed, CutAnywhere_GivesTheTextBeforeAndTruncated) {
  std::mt19937_64 random(7'502);
  const std::string text = random_text(random, 400'000);
  for (const auto& [name, compress] : kinds) {
    const std::string bytes = compress(text);
    for (std::size_t kept = 4; kept < bytes.size(); kept += 1 + bytes.size() / 50) {
      const Text read = decompressed_text(std::string_view(bytes).substr(0, kept));
      ASSERT_TRUE(read.error) << name;
      EXPECT_EQ(read.error->cause, CaptureCause::truncated) << name;
      EXPECT_TRUE(text.starts_with(read.text)) << name;
      if (kept > bytes.size() / 2) {
        EXPECT_GT(read.text.size(), text.size() / 8) << name;
      }
    }
  }
}

TEST(Compressed, DamagedByte_IsDamagedAfterTheTextBefore) {
  std::mt19937_64 random(7'503);
  const std::string text = random_text(random, 400'000);
  for (const auto& [name, compress] : kinds) {
    for (int i = 0; i < 10; ++i) {
      std::string bytes = compress(text);
      const std::size_t at = bytes.size() / 2 + random() % (bytes.size() / 2);
      bytes[at] ^= static_cast<char>(1U << random() % 8);
      const Text read = decompressed_text(bytes);
      ASSERT_TRUE(read.error) << name << ' ' << at;
      EXPECT_TRUE(read.error->cause == CaptureCause::damaged ||
                  read.error->cause == CaptureCause::truncated)
          << name;
      EXPECT_GT(read.text.size(), text.size() / 8) << name;
    }
  }
}

TEST(Compressed, OtherBytesAfterTheLastMember_AreDamaged) {
  for (const auto& [name, compress] : kinds) {
    const Text read = decompressed_text(compress("text") + "garbage");
    EXPECT_EQ(read.text, "text") << name;
    ASSERT_TRUE(read.error) << name;
    EXPECT_EQ(read.error->cause, CaptureCause::damaged) << name;
    EXPECT_NE(std::string(read.error->expected).find("another"), std::string::npos) << name;
  }
}

TEST(Compressed, CapturesOfEveryFormat_AreRead) {
  const std::string csv = "time_ns,MA,SLO\n0,1,1\n1,0,1\n";
  const std::string session = zip_of(session_of({"\3\2"}));
  for (const auto& [name, compress] : kinds) {
    for (const std::size_t block : {std::size_t{1}, one_block}) {
      for (const char* path : {"a.vcd.gz", "a", "-", "a.csv"}) {
        EXPECT_EQ(read_as(compress(vcd), path, block).edges, read_vcd(vcd).edges) << name;
        EXPECT_EQ(read_as(compress(csv), path, block).edges, read_csv(csv).edges) << name;
        EXPECT_EQ(read_as(compress(session), path, block).edges, read_sr(session).edges) << name;
      }
    }
    EXPECT_EQ(read_as(compress(compress(compress(vcd))), "a").edges, read_vcd(vcd).edges) << name;
    const Read deep = read_as(compress(compress(compress(compress(vcd)))), "a");
    EXPECT_EQ(deep.cause(), CaptureCause::unknown_format) << name;
    EXPECT_EQ(read_as(compress("hello"), "a.vcd.gz").cause(), CaptureCause::malformed) << name;
    EXPECT_EQ(read_as(compress(""), "a.vcd.gz").cause(), CaptureCause::empty) << name;
  }
}

TEST(Compressed, RawSamples_AreReadByTheExtensionBelow) {
  const OpenOptions options{.raw = RawLayout{megahertz(1), 1, {{"MA", 0}}}};
  const std::string samples("\0\1\0\1", 4);
  for (const char* path : {"a.bin.gz", "a.raw.zst", "-"}) {
    const Read read = read_all(open_capture(memory_bytes(gzip_of(samples)), path, options));
    EXPECT_EQ(read.edges.size(), 4U) << path;
  }
  // Samples with the extension of samples are samples, whatever they look like.
  const std::string compressed = gzip_of(samples);
  EXPECT_EQ(read_all(open_capture(memory_bytes(compressed), "a.bin", options)).end_time,
            microseconds(static_cast<std::int64_t>(compressed.size()) - 1));
}

TEST(Compressed, DamageInAShortCapture_LosesOnlyWhatComesAfter) {
  // A second member that is damaged.
  for (const auto& [name, compress] : kinds) {
    std::string second = compress("#400 0!\n#500 1!\n");
    second.resize(second.size() - 9);
    const Read read = read_as(compress(vcd) + second, "a.vcd.gz");
    EXPECT_EQ(read.cause(), CaptureCause::truncated) << name;
    EXPECT_EQ(std::vector(read.edges.begin(), read.edges.begin() + 4), read_vcd(vcd).edges) << name;
  }
}

TEST(Compressed, ErrorText_NamesTheCompressedData) {
  std::string bytes = gzip_of(vcd);
  bytes[bytes.size() - 6] ^= 1;
  const Read read = read_as(bytes, "a.vcd.gz");
  ASSERT_TRUE(read.error);
  EXPECT_EQ(
      capture_error_text(*read.error, "a.vcd.gz"),
      "a.vcd.gz: gzip data: is damaged, expected compressed data that inflates to its size and "
      "checksum; copy or save the capture again");
}

TEST(Compressed, BombOfManyMembers_IsReadToItsEnd) {
  // 48 MiB of blank rows in 50 kB.
  std::string bomb;
  const std::string member = gzip_of("time_ns,MA\n0,1\n" + std::string(1U << 20U, '\n'));
  const std::string blank = gzip_of(std::string(1U << 20U, '\n'));
  bomb = member;
  for (int i = 0; i < 47; ++i) bomb += blank;
  const Read read = read_as(bomb, "a.csv.gz");
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.edges.size(), 1U);
}

}  // namespace compressed_test
}  // namespace biss::capture
