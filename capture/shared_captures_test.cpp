#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "capture/open.hpp"
#include "capture/test_capture.hpp"

namespace biss::capture {
namespace {

// The edges of one line, by its name.
std::vector<wire::Edge> edges_of(const Read& read, const std::string& name) {
  const auto found = std::find(read.lines.begin(), read.lines.end(), name);
  const auto line = static_cast<wire::LineIndex>(found - read.lines.begin());
  std::vector<wire::Edge> edges;
  for (wire::Edge edge : read.edges) {
    if (edge.line != line) continue;
    edge.line = 0;
    edges.push_back(edge);
  }
  return edges;
}

TEST(SharedCaptures, VcdAndCsvOfOneCapture_GiveTheSameEdges) {
  const auto folder = shared_captures();
  if (!folder) GTEST_SKIP() << "no reference captures: set BISS_SHARED to their folder";
  for (const std::string name :
       {"hardware_32bit_1MHz", "cores_26bit_1MHz", "cores_26bit_10MHz_delay200ns"}) {
    SCOPED_TRACE(name);
    const Read vcd = read_all(open_capture((*folder / (name + ".vcd")).string()));
    const Read csv = read_all(open_capture((*folder / (name + ".csv")).string()));
    ASSERT_FALSE(vcd.error);
    ASSERT_FALSE(csv.error);
    for (const std::string line : {"MA", "SLO"}) {
      const std::vector<wire::Edge> edges = edges_of(vcd, line);
      EXPECT_GT(edges.size(), 10U);
      EXPECT_EQ(edges, edges_of(csv, line)) << line;
    }
  }
}

}  // namespace
}  // namespace biss::capture
