#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "report/hdf5.hpp"
#include "report/hdf5_file.hpp"
#include "report/text.hpp"

namespace biss::report {
namespace {

constexpr std::size_t block_rows = 16384;
// A double holds integers up to this width.
constexpr unsigned double_bits = 53;

// How the values of a data set are stored. The order is that of `types`.
enum class Storage : std::uint8_t { real, wide_unsigned, wide_signed, flag, code, bit_count };

struct StorageType {
  hid_t (*type)();
  std::size_t bytes;
  const char* matlab;
};

constexpr std::array<StorageType, 6> types{{
    {[] { return H5T_IEEE_F64LE; }, 8, "double"},
    {[] { return H5T_STD_U64LE; }, 8, "uint64"},
    {[] { return H5T_STD_I64LE; }, 8, "int64"},
    {[] { return H5T_STD_U8LE; }, 1, "uint8"},
    {[] { return H5T_STD_U32LE; }, 4, "uint32"},
    {[] { return H5T_STD_U16LE; }, 2, "uint16"},
}};

const StorageType& type_of(Storage storage) { return types[static_cast<std::size_t>(storage)]; }

Storage storage_of(const Column& column) {
  const bool narrow = column.bits != 0 && column.bits <= double_bits;
  switch (column.kind) {
    case Kind::unsigned_integer:
      return narrow ? Storage::real : Storage::wide_unsigned;
    case Kind::signed_integer:
      return narrow ? Storage::real : Storage::wide_signed;
    case Kind::bits:
      return Storage::wide_unsigned;
    case Kind::flag:
      return Storage::flag;
    case Kind::text:
    case Kind::absent:
      return Storage::code;
    case Kind::nanoseconds:
    case Kind::real:
      break;
  }
  return Storage::real;
}

bool put_attribute(hid_t object, const char* name, std::string_view text) {
  if (text.empty()) return true;
  const Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  const Hdf5Id space(H5Screate(H5S_SCALAR), H5Sclose);
  if (H5Tset_size(type.get(), text.size()) < 0) return false;
  const Hdf5Id made(H5Acreate2(object, name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT),
                    H5Aclose);
  return made.good() && H5Awrite(made.get(), type.get(), text.data()) >= 0;
}

bool put_attribute(hid_t object, const char* name, hid_t type, const void* value) {
  const Hdf5Id space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Id made(H5Acreate2(object, name, type, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                    H5Aclose);
  return made.good() && H5Awrite(made.get(), type, value) >= 0;
}

// A data set of some lanes with a value each row, and the block of it that is being filled.
class DataSet {
 public:
  DataSet(std::string name, std::string unit, Storage storage, std::size_t lanes, bool zero_absent)
      : name_(std::move(name)),
        unit_(std::move(unit)),
        storage_(storage),
        lanes_(lanes),
        says_absent_(!zero_absent && storage != Storage::real) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    if (storage == Storage::real) {
      std::memcpy(absent_.data(), &nan, sizeof nan);
    } else if (says_absent_ && storage == Storage::wide_signed) {
      const auto least = std::numeric_limits<std::int64_t>::min();
      std::memcpy(absent_.data(), &least, sizeof least);
    } else if (says_absent_) {
      absent_.fill(0xFF);
    }
    block_.resize(lanes * block_rows * bytes());
    clear();
  }

  // The values of a row are absent until they are put.
  template <class Value>
  void put(std::size_t row, Value value, std::size_t lane = 0) {
    used_ = true;
    std::memcpy(block_.data() + (lane * block_rows + row) * sizeof value, &value, sizeof value);
  }

  // The last block of a long table, all of a short one.
  bool write(hid_t file, std::uint64_t first_row, std::size_t rows, bool is_last) {
    if (!set_.good() && !create(file, is_last, rows)) return false;
    if (chunked_ && !resize(first_row + rows)) return false;
    // A block without a value is not written: it reads as absent and takes no space.
    if (used_ && !(chunked_ ? write_chunk(first_row) : write_all(rows))) return false;
    if (used_) clear();
    used_ = false;
    return !is_last || set_.close();
  }

 private:
  std::size_t bytes() const { return type_of(storage_).bytes; }

  void clear() {
    if (bytes() == sizeof(std::uint64_t)) {
      std::uint64_t value = 0;
      std::memcpy(&value, absent_.data(), sizeof value);
      auto* const first = reinterpret_cast<std::uint64_t*>(block_.data());
      std::fill(first, first + block_.size() / sizeof value, value);
    } else {
      std::memset(block_.data(), absent_[0], block_.size());
    }
  }

  // `whole`: with all rows of a table; else it grows by blocks.
  bool create(hid_t file, bool whole, std::size_t rows) {
    chunked_ = !whole;
    const std::array<hsize_t, 2> size{lanes_, rows};
    const std::array<hsize_t, 2> most{lanes_, chunked_ ? H5S_UNLIMITED : rows};
    const std::array<hsize_t, 2> chunk{lanes_, block_rows};
    const Hdf5Id space(H5Screate_simple(2, size.data(), most.data()), H5Sclose);
    const Hdf5Id setup(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    const hid_t type = type_of(storage_).type();
    const bool ready = space.good() && H5Pset_obj_track_times(setup.get(), false) >= 0 &&
                       H5Pset_fill_value(setup.get(), type, absent_.data()) >= 0 &&
                       (!chunked_ || H5Pset_chunk(setup.get(), 2, chunk.data()) >= 0);
    if (!ready) return false;
    set_ = Hdf5Id(
        H5Dcreate2(file, name_.c_str(), type, space.get(), H5P_DEFAULT, setup.get(), H5P_DEFAULT),
        H5Dclose);
    return set_.good() && put_attribute(set_.get(), "MATLAB_class", type_of(storage_).matlab) &&
           put_attribute(set_.get(), "unit", unit_) &&
           (!says_absent_ || put_attribute(set_.get(), "absent_value", type, absent_.data()));
  }

  bool resize(std::uint64_t rows) {
    const std::array<hsize_t, 2> size{lanes_, rows};
    return H5Dset_extent(set_.get(), size.data()) >= 0;
  }

  bool write_chunk(std::uint64_t first_row) {
    const std::array<hsize_t, 2> place{0, first_row};
    return H5Dwrite_chunk(set_.get(), H5P_DEFAULT, 0, place.data(), block_.size(), block_.data()) >=
           0;
  }

  bool write_all(std::size_t rows) {
    const std::array<hsize_t, 2> size{lanes_, block_rows};
    const std::array<hsize_t, 2> first{0, 0};
    const std::array<hsize_t, 2> part{lanes_, rows};
    const Hdf5Id memory(H5Screate_simple(2, size.data(), nullptr), H5Sclose);
    return H5Sselect_hyperslab(memory.get(), H5S_SELECT_SET, first.data(), nullptr, part.data(),
                               nullptr) >= 0 &&
           H5Dwrite(set_.get(), type_of(storage_).type(), memory.get(), H5S_ALL, H5P_DEFAULT,
                    block_.data()) >= 0;
  }

  std::string name_;
  std::string unit_;
  Storage storage_;
  std::size_t lanes_;
  bool says_absent_;
  std::array<std::uint8_t, 8> absent_{};
  std::vector<std::uint8_t> block_;
  bool used_ = false;
  bool chunked_ = false;
  Hdf5Id set_;
};

// The texts of a column by number, from 1 on; 0 is none.
class Texts {
 public:
  std::uint32_t number_of(std::string_view text) {
    if (last_ != nullptr && last_->first == text) return last_->second;
    const auto known = numbers_.find(text);
    const auto next = static_cast<std::uint32_t>(numbers_.size() + 1);
    last_ = known != numbers_.end() ? &*known : &*numbers_.emplace(std::string(text), next).first;
    return last_->second;
  }

  // As MATLAB stores a matrix of characters: a row a text, padded with spaces.
  bool write(hid_t file, const std::string& name) const {
    if (numbers_.empty()) return true;
    std::vector<std::u16string> texts(numbers_.size());
    std::size_t longest = 1;
    for (const auto& [text, number] : numbers_) {
      texts[number - 1] = utf16_of(text);
      longest = std::max(longest, texts[number - 1].size());
    }
    std::vector<std::uint16_t> units(longest * texts.size(), u' ');
    for (std::size_t i = 0; i < texts.size(); ++i) {
      for (std::size_t k = 0; k < texts[i].size(); ++k) units[k * texts.size() + i] = texts[i][k];
    }
    const std::array<hsize_t, 2> size{longest, texts.size()};
    const Hdf5Id setup(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    const Hdf5Id space(H5Screate_simple(2, size.data(), nullptr), H5Sclose);
    if (H5Pset_obj_track_times(setup.get(), false) < 0) return false;
    const Hdf5Id set(H5Dcreate2(file, name.c_str(), H5T_STD_U16LE, space.get(), H5P_DEFAULT,
                                setup.get(), H5P_DEFAULT),
                     H5Dclose);
    constexpr std::int32_t as_characters = 2;
    return set.good() && put_attribute(set.get(), "MATLAB_class", "char") &&
           put_attribute(set.get(), "MATLAB_int_decode", H5T_STD_I32LE, &as_characters) &&
           H5Dwrite(set.get(), H5T_STD_U16LE, H5S_ALL, H5S_ALL, H5P_DEFAULT, units.data()) >= 0;
  }

 private:
  static std::u16string utf16_of(std::string_view text) {
    std::u16string units;
    while (!text.empty()) {
      const CodePoint point = front_code_point(text);
      const char32_t value = point.valid ? point.value : U'\uFFFD';
      if (value >= 0x10000) {
        units.push_back(static_cast<char16_t>(0xD7C0 + (value >> 10U)));
        units.push_back(static_cast<char16_t>(0xDC00 + (value & 0x3FFU)));
      } else {
        units.push_back(static_cast<char16_t>(value));
      }
      text.remove_prefix(point.bytes);
    }
    return units;
  }

  std::map<std::string, std::uint32_t, std::less<>> numbers_;
  const std::pair<const std::string, std::uint32_t>* last_ = nullptr;
};

// A column as its data sets.
class StoredColumn {
 public:
  explicit StoredColumn(const Column& column)
      : name_(column.name),
        kind_(column.kind),
        storage_(storage_of(column)),
        words_(column.kind == Kind::bits ? std::max((column.bits + 63U) / 64U, 1U) : 1U),
        values_(name_, column.kind == Kind::nanoseconds ? "ns" : column.value_unit, storage_,
                words_, column.kind == Kind::bits || storage_ == Storage::code) {
    if (kind_ == Kind::bits) bit_counts_.emplace(name_ + "_bits", "", Storage::bit_count, 1, true);
  }

  // False where the cell is not what the column says.
  bool put(std::size_t row, const Cell& cell) {
    if (cell.kind() == Kind::absent) return true;
    if (cell.kind() != kind_) return false;
    switch (kind_) {
      case Kind::absent:
        break;
      case Kind::nanoseconds:
        values_.put(row, static_cast<double>(cell.time().count) / 1000.0);
        break;
      case Kind::real:
        values_.put(row, cell.real_value());
        break;
      case Kind::flag:
        values_.put(row, static_cast<std::uint8_t>(cell.unsigned_value()));
        break;
      case Kind::text:
        values_.put(row, texts_.number_of(cell.text()));
        break;
      case Kind::unsigned_integer:
        return put_unsigned(row, cell.unsigned_value());
      case Kind::signed_integer:
        return put_signed(row, cell.signed_value());
      case Kind::bits:
        return put_bits(row, cell.bits());
    }
    return true;
  }

  bool write(hid_t file, std::uint64_t first_row, std::size_t rows, bool is_last) {
    return values_.write(file, first_row, rows, is_last) &&
           (!bit_counts_ || bit_counts_->write(file, first_row, rows, is_last)) &&
           (!is_last || texts_.write(file, name_ + "_names"));
  }

 private:
  bool put_unsigned(std::size_t row, std::uint64_t value) {
    if (storage_ != Storage::real) {
      values_.put(row, value);
      return true;
    }
    values_.put(row, static_cast<double>(value));
    return value >> double_bits == 0;
  }

  bool put_signed(std::size_t row, std::int64_t value) {
    if (storage_ != Storage::real) {
      values_.put(row, value);
      return true;
    }
    values_.put(row, static_cast<double>(value));
    return magnitude_of(value).value >> double_bits == 0;
  }

  // One number of several words, the most significant one first.
  bool put_bits(std::size_t row, BitView bits) {
    if (bits.size_bits() > std::size_t{words_} * 64) return false;
    bit_counts_->put(row, static_cast<std::uint16_t>(bits.size_bits()));
    for (std::size_t end = bits.size_bits(), lane = words_; lane-- > 0;) {
      const auto taken = static_cast<unsigned>(std::min<std::size_t>(end, 64));
      end -= taken;
      values_.put(row, bits.word(end, taken), lane);
    }
    return true;
  }

  std::string name_;
  Kind kind_;
  Storage storage_;
  unsigned words_;
  DataSet values_;
  std::optional<DataSet> bit_counts_;
  Texts texts_;
};

// Tells MATLAB that this is a file of version 7.3: 116 bytes of text, an offset that is not used, the
// version 2.0 and the byte order.
std::array<std::byte, hdf5_user_bytes> matlab_header() {
  constexpr std::string_view text = "MATLAB 7.3 MAT-file, Platform: biss, HDF5 schema 1.00 .";
  constexpr std::array<unsigned char, 4> version{0x00, 0x02, 'I', 'M'};
  std::array<std::byte, hdf5_user_bytes> header{};
  std::fill_n(header.begin(), 116, std::byte{' '});
  std::memcpy(header.data(), text.data(), text.size());
  std::memcpy(header.data() + 124, version.data(), version.size());
  return header;
}

class Hdf5Writer final : public TableWriter {
 public:
  Hdf5Writer(std::span<const Column> columns, FileSink& sink)
      : sink_(sink), file_(create_hdf5_file(sink)) {
    for (const Column& column : columns) columns_.emplace_back(column);
    if (!file_.good()) fail("HDF5: the library cannot create the file");
  }

  bool row(std::span<const Cell> cells) override {
    if (!good_) return false;
    if (rows_ == block_rows && !write_block(false)) return false;
    const std::size_t count = std::min(cells.size(), columns_.size());
    for (std::size_t i = 0; i < count; ++i) {
      if (!columns_[i].put(rows_, cells[i])) return fail("HDF5: a value does not fit its column");
    }
    ++rows_;
    return true;
  }

  bool finish() override {
    if (!good_ || !write_block(true)) return false;
    if (!file_.close()) return fail("HDF5: the library cannot close the file");
    const auto header = matlab_header();
    return good_ = sink_.write_at(0, header);
  }

 private:
  bool write_block(bool is_last) {
    for (StoredColumn& column : columns_) {
      if (!column.write(file_.get(), written_, rows_, is_last)) {
        return fail("HDF5: the library cannot write a column");
      }
    }
    written_ += rows_;
    rows_ = 0;
    // What the library does not know: see create_hdf5_file().
    return good_ = sink_.write_at(0, {});
  }

  bool fail(std::string_view cause) {
    sink_.fail(cause);
    return good_ = false;
  }

  FileSink& sink_;
  // Closed after the columns.
  Hdf5Id file_;
  std::vector<StoredColumn> columns_;
  std::uint64_t written_ = 0;
  std::size_t rows_ = 0;
  bool good_ = true;
};

}  // namespace

std::unique_ptr<TableWriter> make_hdf5_writer(std::span<const Column> columns, FileSink& sink) {
  return std::make_unique<Hdf5Writer>(columns, sink);
}

}  // namespace biss::report
