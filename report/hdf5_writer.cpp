// Writes a table as HDF5, with a data set for each column.
#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "report/hdf5.hpp"
#include "report/hdf5_data_set.hpp"
#include "report/text.hpp"

namespace biss::report {
namespace {

// A double holds integers up to this width.
constexpr unsigned double_bits = 53;

Hdf5Storage storage_of(const Column& column) {
  using enum Hdf5Storage;
  // In the order of Kind.
  constexpr std::array<Hdf5Storage, kind_names.size()> usual{
      code, wide_unsigned, wide_signed, real, real, code, wide_unsigned, flag};
  const bool integer = column.kind == Kind::unsigned_integer || column.kind == Kind::signed_integer;
  const bool narrow = column.bits != 0 && column.bits <= double_bits;
  return integer && narrow ? real : usual[static_cast<std::size_t>(column.kind)];
}

// The texts of a column by number, from 1 on; 0 means no text.
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
    const Hdf5Id setup(BISS_HDF5(H5Pcreate)(BISS_HDF5(H5P_CLS_DATASET_CREATE_ID_g)),
                       BISS_HDF5(H5Pclose));
    const Hdf5Id space(BISS_HDF5(H5Screate_simple)(2, size.data(), nullptr), BISS_HDF5(H5Sclose));
    if (BISS_HDF5(H5Pset_obj_track_times)(setup.get(), false) < 0) return false;
    const Hdf5Id set(BISS_HDF5(H5Dcreate2)(file, name.c_str(), BISS_HDF5(H5T_STD_U16LE_g),
                                           space.get(), H5P_DEFAULT, setup.get(), H5P_DEFAULT),
                     BISS_HDF5(H5Dclose));
    constexpr std::int32_t as_characters = 2;
    return set.good() && put_hdf5_attribute(set.get(), "MATLAB_class", "char") &&
           put_hdf5_attribute(set.get(), "MATLAB_int_decode", BISS_HDF5(H5T_STD_I32LE_g),
                              &as_characters) &&
           BISS_HDF5(H5Dwrite)(set.get(), BISS_HDF5(H5T_STD_U16LE_g), H5S_ALL, H5S_ALL, H5P_DEFAULT,
                               units.data()) >= 0;
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
                words_, column.kind == Kind::bits || storage_ == Hdf5Storage::code) {
    if (kind_ == Kind::bits)
      bit_counts_.emplace(name_ + "_bits", "", Hdf5Storage::bit_count, 1, true);
  }

  // False if the cell does not fit the column.
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
        return put_integer(row, cell.unsigned_value(), cell.unsigned_value());
      case Kind::signed_integer:
        return put_integer(row, cell.signed_value(), magnitude_of(cell.signed_value()).value);
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
  template <class Value>
  bool put_integer(std::size_t row, Value value, std::uint64_t magnitude) {
    if (storage_ != Hdf5Storage::real) {
      values_.put(row, value);
      return true;
    }
    values_.put(row, static_cast<double>(value));
    return magnitude >> double_bits == 0;
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
  Hdf5Storage storage_;
  unsigned words_;
  Hdf5DataSet values_;
  std::optional<Hdf5DataSet> bit_counts_;
  Texts texts_;
};

// Marks the file for MATLAB as one of version 7.3: 116 bytes of text, an offset that is not used, the
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
    if (file_.good()) return;
    fail(load_hdf5() ? std::string("HDF5: the library cannot create the file")
                     : std::string("HDF5: the library ") + hdf5_file + " cannot be loaded");
  }

  bool row(std::span<const Cell> cells) override {
    if (!good_) return false;
    if (rows_ == hdf5_block_rows && !write_block(false)) return false;
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
    // The library does not see a failed write; see create_hdf5_file().
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
