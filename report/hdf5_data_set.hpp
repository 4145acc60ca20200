// Within the HDF5 writer: a data set that grows by blocks of rows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "report/hdf5_file.hpp"

namespace biss::report {

inline constexpr std::size_t hdf5_block_rows = 16384;

/// The storage of a data set's values, which are put as double, uint64, int64, uint8, uint32 or
/// uint16, in this order.
enum class Hdf5Storage : std::uint8_t { real, wide_unsigned, wide_signed, flag, code, bit_count };

/// An attribute with one value; an empty text is left out. False when the library failed.
bool put_hdf5_attribute(hid_t object, const char* name, std::string_view text);
bool put_hdf5_attribute(hid_t object, const char* name, hid_t type, const void* value);

/// A data set of some lanes with a value each row, and the block of it that is being filled.
class Hdf5DataSet {
 public:
  /// \param zero_absent 0 means that a value is absent; else NaN, the least or the greatest value
  Hdf5DataSet(std::string name, std::string unit, Hdf5Storage storage, std::size_t lanes,
              bool zero_absent);

  /// Puts a value of the type of `storage`. The values of a row are absent until they are put.
  /// \pre row is less than hdf5_block_rows
  template <class Value>
  void put(std::size_t row, Value value, std::size_t lane = 0) {
    used_ = true;
    std::memcpy(block_.data() + (lane * hdf5_block_rows + row) * sizeof value, &value,
                sizeof value);
  }

  /// Writes the first `rows` rows of the block and clears it. Every block except the last one is
  /// full. False if the library failed.
  bool write(hid_t file, std::uint64_t first_row, std::size_t rows, bool is_last);

 private:
  std::size_t bytes() const;
  void clear();
  bool create(hid_t file, bool whole, std::size_t rows);
  bool resize(std::uint64_t rows);
  bool write_chunk(std::uint64_t first_row);
  bool write_all(std::size_t rows);

  std::string name_;
  std::string unit_;
  Hdf5Storage storage_;
  std::size_t lanes_;
  bool says_absent_;
  std::array<std::uint8_t, 8> absent_{};
  std::vector<std::uint8_t> block_;
  bool used_ = false;
  bool chunked_ = false;
  Hdf5Id set_;
};

}  // namespace biss::report
