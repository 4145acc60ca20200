// Reads the files of published frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace published {

/// One published word.
struct Vector {
  std::string name;
  /// In the grammar of frame formats.
  std::string format;
  std::uint64_t position = 0;
  std::uint64_t life_counter = 0;
  bool nE = true;
  bool nW = true;
  /// As transmitted.
  std::uint64_t crc = 0;
  /// Position, flags, counter and CRC as 1 and 0 in transmission order.
  std::string bits;
};

struct File {
  std::vector<Vector> vectors;
  /// The number of lines with data, counted without parsing.
  std::size_t data_lines = 0;
};

/// Reads `vectors.csv`. Throws with the fault of a line.
File read_vectors(const std::string& path);
/// `slave_log.txt`: MT12, ST12, two flags, CRC6.
File read_slave_log(const std::string& path);

}  // namespace published
