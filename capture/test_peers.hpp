// Shared by the tests with other programs: a folder for their files, running them, and the changes
// of each line of a capture.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "capture/open.hpp"
#include "capture/test_capture.hpp"
#include "capture/test_folder.hpp"

namespace biss::capture {

inline bool runs(const std::string& command) {
  return std::system((command + " >/dev/null 2>&1").c_str()) == 0;
}

using test::content_of;
using test::Folder;

// The changes of each line, by its name below `tb`.
using Changes = std::map<std::string, std::vector<std::pair<std::int64_t, wire::Level>>>;

inline Changes changes_of(const std::string& path) {
  const Read read = read_all(open_capture(path));
  EXPECT_FALSE(read.error) << capture_error_text(*read.error, path);
  std::vector<std::string> names = read.lines;
  for (std::string& name : names) name = name.starts_with("tb.") ? name.substr(3) : name;
  Changes changes;
  for (const std::string& name : names) changes[name];
  for (const wire::Edge& edge : read.edges) {
    changes[names[edge.line]].emplace_back(edge.time.count, edge.level);
  }
  EXPECT_EQ(changes.size(), read.lines.size());
  return changes;
}

}  // namespace biss::capture
