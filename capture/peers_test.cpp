// Capture files of this project in other programs, and theirs in its readers. scripts/packages.txt
// lists the packages. Where they are missing, the tests report themselves as skipped.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "capture/open.hpp"
#include "capture/samples.hpp"
#include "capture/sr.hpp"
#include "capture/test_samples.hpp"
#include "capture/vcd.hpp"

namespace biss::capture {
namespace peers_test {

bool runs(const std::string& command) {
  return std::system((command + " >/dev/null 2>&1").c_str()) == 0;
}

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class Folder {
 public:
  Folder() {
    std::string name = testing::TempDir() + "biss-peers-XXXXXX";
    if (mkdtemp(name.data()) == nullptr) std::abort();
    folder_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

 private:
  std::filesystem::path folder_;
};

struct Lines {
  std::vector<std::string> names;
  std::vector<wire::Edge> edges;
  Picoseconds end;
};

constexpr Hertz rate = megahertz(100);

// Edges at sample times: bursts as of request cycles, long idle times between them, more than one
// chunk.
Lines bursts(std::size_t count, unsigned longest_idle = 200'000) {
  Lines lines;
  for (std::size_t i = 0; i < count; ++i) lines.names.push_back("L" + std::to_string(i));
  lines.names[0] = "MA";
  std::mt19937_64 random(7'407);
  for (std::size_t i = 0; i < count; ++i) {
    lines.edges.push_back({{}, static_cast<wire::LineIndex>(i), wire::Level::high});
  }
  std::vector<bool> high(count, true);
  Picoseconds now{};
  for (int burst = 0; burst < 60; ++burst) {
    now += nanoseconds(10) * static_cast<std::int64_t>(1 + random() % longest_idle);
    for (int i = 0; i < 100; ++i) {
      now += nanoseconds(10) * static_cast<std::int64_t>(1 + random() % 9);
      const std::size_t line = random() % count;
      high[line] = !high[line];
      lines.edges.push_back({now, static_cast<wire::LineIndex>(line),
                             high[line] ? wire::Level::high : wire::Level::low});
    }
  }
  lines.end = now + microseconds(1);
  return lines;
}

// `arguments` come before the sink.
template <class Writer, class... Arguments>
std::string written(const Lines& lines, const Arguments&... arguments) {
  std::string bytes;
  StringSink sink(bytes);
  Writer writer(arguments..., sink);
  EXPECT_TRUE(writer.write(lines.edges).ok());
  EXPECT_TRUE(writer.finish(lines.end).ok());
  return bytes;
}

// An FST keeps no order among the changes of one time.
std::vector<wire::Edge> by_line(std::vector<wire::Edge> edges) {
  std::stable_sort(edges.begin(), edges.end(),
                   [](const wire::Edge& a, const wire::Edge& b) { return a.line < b.line; });
  return edges;
}

void save(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

constexpr const char* no_sigrok = "no sigrok-cli: scripts/install-packages test";

class Sigrok : public testing::TestWithParam<std::size_t> {
 protected:
  void SetUp() override {
    if (!runs("sigrok-cli --version")) GTEST_SKIP() << no_sigrok;
    lines_ = bursts(GetParam());
    save(folder_.path("ours.sr"), written<SrWriter>(lines_, lines_.names, rate));
  }

  // The session converted by sigrok-cli to that format.
  std::string theirs(const std::string& format, const std::string& name) const {
    const std::string path = folder_.path(name);
    EXPECT_TRUE(runs("sigrok-cli -i " + folder_.path("ours.sr") + " -O " + format + " -o " + path));
    return path;
  }

  Folder folder_;
  Lines lines_;
};

TEST_P(Sigrok, OurSession_HasTheSameLevelsThere) {
  const std::string samples = content_of(theirs("binary", "theirs.bin"));
  const std::string ours = written<RawWriter>(lines_, packed_layout(lines_.names, rate));
  EXPECT_EQ(samples.size(), ours.size());
  EXPECT_TRUE(samples == ours);
}

TEST_P(Sigrok, SessionItWroteFromOurs_HasTheSameEdges) {
  const Read read = read_all(open_capture(theirs("srzip", "theirs.sr")));
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.lines, lines_.names);
  EXPECT_EQ(read.edges, lines_.edges);
  EXPECT_EQ(read.end_time, lines_.end);
}

TEST_P(Sigrok, VcdItWroteFromOurs_HasTheSameEdges) {
  const Read read = read_all(open_capture(theirs("vcd", "theirs.vcd")));
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.lines, lines_.names);
  EXPECT_EQ(read.edges, lines_.edges);
}

// Without times the first sample is at 0, with times one period later.
TEST(SigrokCsv, CsvItWroteFromOurSession_HasTheSameEdges) {
  if (!runs("sigrok-cli --version")) GTEST_SKIP() << no_sigrok;
  const Folder folder;
  const Lines lines = bursts(3, 100);
  save(folder.path("ours.sr"), written<SrWriter>(lines, lines.names, rate));
  for (const std::string format :
       {"csv", "csv:label=channel", "csv:time=true", "csv:time=true:label=channel:dedup=true"}) {
    SCOPED_TRACE(format);
    ASSERT_TRUE(runs("sigrok-cli -i " + folder.path("ours.sr") + " -O " + format + " -o " +
                     folder.path("theirs.csv")));
    const Read read = read_all(open_capture(folder.path("theirs.csv")));
    EXPECT_FALSE(read.error);
    EXPECT_EQ(read.lines, lines.names);
    std::vector<wire::Edge> expected = lines.edges;
    for (wire::Edge& edge : expected) {
      edge.time += nanoseconds(format.find("time") != std::string::npos ? 10 : 0);
    }
    EXPECT_EQ(read.edges, expected);
  }
}

TEST(SigrokAnalog, CsvOfItsDemoDevice_HasItsSquareWave) {
  if (!runs("sigrok-cli --version")) GTEST_SKIP() << no_sigrok;
  const Folder folder;
  const std::string path = folder.path("demo.csv");
  ASSERT_TRUE(
      runs("sigrok-cli -d demo:analog_channels=2:logic_channels=1 --samples 20000 --config "
           "samplerate=1m -O csv -o " +
           path));
  const Read read = read_all(open_capture(path));
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.lines, (std::vector<std::string>{"D0", "A0", "A1"}));
  // One channel is a square wave, one a sine, of ten samples a period and up; both cross 0 V.
  for (const wire::LineIndex line : {1U, 2U}) {
    const auto changes =
        std::count_if(read.edges.begin(), read.edges.end(),
                      [line](const wire::Edge& edge) { return edge.line == line; });
    EXPECT_GT(changes, 100) << line;
  }
}

INSTANTIATE_TEST_SUITE_P(Lines, Sigrok, testing::Values(2, 9, 32));

TEST(Gtkwave, OurVcd_BecomesAnFstWithTheSameEdges) {
  // Without arguments both print their usage and fail.
  if (!runs("command -v vcd2fst") || !runs("command -v fst2vcd")) {
    GTEST_SKIP() << "no vcd2fst: scripts/install-packages test";
  }
  const Folder folder;
  Lines lines = bursts(3);
  lines.edges.insert(lines.edges.begin() + 50, {lines.edges[49].time, 2, wire::Level::unknown});
  save(folder.path("ours.vcd"), written<VcdWriter>(lines, lines.names));
  ASSERT_TRUE(runs("vcd2fst " + folder.path("ours.vcd") + " " + folder.path("theirs.fst")));
  ASSERT_TRUE(runs("fst2vcd -f " + folder.path("theirs.fst") + " -o " + folder.path("back.vcd")));
  const Read ours = read_all(open_capture(folder.path("ours.vcd")));
  const Read back = read_all(open_capture(folder.path("back.vcd")));
  EXPECT_FALSE(back.error);
  EXPECT_EQ(back.lines, ours.lines);
  EXPECT_EQ(by_line(back.edges), by_line(ours.edges));
}

}  // namespace peers_test
}  // namespace biss::capture
