// A short block of facts printed in addition to the data.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace biss::report {

/// Lines of key, value and note in aligned columns, for people:
///
///     clock       10.000 MHz  (9.998 .. 10.000 .. 10.002)
///     line delay  112 ns      compensated
class Summary {
 public:
  /// A separate line above the next entries, after a blank line unless it is the first.
  void title(std::string_view text);
  /// A line; an empty key continues the line above.
  void entry(std::string_view key, std::string_view value, std::string_view note = {});

  bool empty() const { return lines_.empty(); }
  /// The block, each line ended by `\n`; control characters are replaced.
  std::string text() const;

 private:
  struct Line {
    bool is_title = false;
    std::string key;
    std::string value;
    std::string note;
  };
  std::vector<Line> lines_;
};

/// `1 cycle`, `2 cycles`.
std::string counted(std::uint64_t count, std::string_view noun);

/// Appends `12 ok` to a list with commas, unless the count is 0.
void append_count(std::string& list, std::uint64_t count, std::string_view name);

}  // namespace biss::report
