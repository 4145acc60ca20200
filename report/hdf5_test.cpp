#include "report/hdf5.hpp"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

namespace biss::report {
namespace hdf5_test {

// A file in memory that fails as soon as it would have more than `most` bytes.
class MemoryFile final : public FileSink {
 public:
  explicit MemoryFile(std::size_t most = std::size_t{64} << 20U) : most_(most) {}

  bool write_at(std::uint64_t offset, std::span<const std::byte> piece) override {
    if (failed || offset + piece.size() > most_) {
      failed = true;
      return false;
    }
    if (bytes.size() < offset + piece.size()) bytes.resize(offset + piece.size());
    std::copy(piece.begin(), piece.end(), bytes.begin() + static_cast<std::ptrdiff_t>(offset));
    return true;
  }
  bool read_at(std::uint64_t offset, std::span<std::byte> piece) override {
    std::fill(piece.begin(), piece.end(), std::byte{});
    for (std::size_t i = 0; i < piece.size() && offset + i < bytes.size(); ++i) {
      piece[i] = bytes[offset + i];
    }
    return !failed;
  }
  void fail(std::string_view why) override {
    cause = why;
    failed = true;
  }

  std::vector<std::byte> bytes;
  std::string cause;
  bool failed = false;

 private:
  std::size_t most_;
};

// The contents of a file, read by the library's own reader of files.
class Content {
 public:
  explicit Content(const std::vector<std::byte>& bytes) {
    std::string name = (std::filesystem::temp_directory_path() / "biss-hdf5-XXXXXX").string();
    const int descriptor = ::mkstemp(name.data());
    EXPECT_GE(descriptor, 0);
    std::ofstream(name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    file_ = H5Fopen(name.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    EXPECT_GE(file_, 0);
    std::filesystem::remove(name);
  }
  Content(const Content&) = delete;
  Content& operator=(const Content&) = delete;
  ~Content() { H5Fclose(file_); }

  std::vector<hsize_t> size_of(const std::string& name) const {
    const hid_t set = H5Dopen2(file_, name.c_str(), H5P_DEFAULT);
    const hid_t space = H5Dget_space(set);
    std::vector<hsize_t> size(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
    H5Sget_simple_extent_dims(space, size.data(), nullptr);
    H5Sclose(space);
    H5Dclose(set);
    return size;
  }
  std::uint64_t bytes_of(const std::string& name) const {
    const hid_t set = H5Dopen2(file_, name.c_str(), H5P_DEFAULT);
    const std::uint64_t bytes = H5Dget_storage_size(set);
    H5Dclose(set);
    return bytes;
  }
  // All values, row by row; of several words, word by word.
  template <class Value>
  std::vector<Value> values(const std::string& name, hid_t type) const {
    std::vector<Value> values;
    const auto size = size_of(name);
    values.resize(size[0] * size[1]);
    const hid_t set = H5Dopen2(file_, name.c_str(), H5P_DEFAULT);
    EXPECT_GE(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0) << name;
    H5Dclose(set);
    return values;
  }
  std::vector<double> numbers(const std::string& name) const {
    return values<double>(name, H5T_NATIVE_DOUBLE);
  }
  std::vector<std::uint64_t> integers(const std::string& name) const {
    return values<std::uint64_t>(name, H5T_NATIVE_UINT64);
  }
  bool has(const std::string& name) const {
    return H5Lexists(file_, name.c_str(), H5P_DEFAULT) > 0;
  }
  std::string attribute(const std::string& set, const std::string& name) const {
    if (H5Aexists_by_name(file_, set.c_str(), name.c_str(), H5P_DEFAULT) <= 0) return "none";
    const hid_t found = H5Aopen_by_name(file_, set.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    const hid_t type = H5Aget_type(found);
    std::string text(H5Tget_size(type), '\0');
    EXPECT_GE(H5Aread(found, type, text.data()), 0);
    H5Tclose(type);
    H5Aclose(found);
    return text;
  }

 private:
  hid_t file_ = -1;
};

const std::vector<std::uint8_t> raw_bytes = {0x81, 0x23, 0x45, 0x67, 0x89, 0xAB, 0xCD, 0xEF, 0x10};

std::vector<Column> columns_of_each_kind() {
  return {{.name = "cycle", .kind = Kind::unsigned_integer, .bits = 53},
          {.name = "wide", .kind = Kind::unsigned_integer, .value_unit = "counts"},
          {.name = "signed", .kind = Kind::signed_integer},
          {.name = "time_ns", .kind = Kind::nanoseconds},
          {.name = "real", .kind = Kind::real, .value_unit = "deg"},
          {.name = "status", .kind = Kind::text},
          {.name = "flag", .kind = Kind::flag},
          {.name = "raw", .kind = Kind::bits, .bits = 72}};
}

std::vector<std::byte> file_of(const std::vector<Column>& columns,
                               const std::vector<std::vector<Cell>>& rows) {
  MemoryFile file;
  const auto writer = make_hdf5_writer(columns, file);
  for (const auto& row : rows) EXPECT_TRUE(writer->row(row));
  EXPECT_TRUE(writer->finish());
  EXPECT_FALSE(file.failed) << file.cause;
  return file.bytes;
}

TEST(Hdf5, EachKindOfValue_ReadsBackWithItsUnit) {
  constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  const Content file(file_of(
      columns_of_each_kind(),
      {{7U, most - 1, std::int64_t{-5}, picoseconds(12'500'125), 0.1, "ok", true,
        BitView(raw_bytes, 0, 72)},
       {8U, 3U, std::int64_t{9}, picoseconds(-1), -2.5, "crc", false, BitView(raw_bytes, 0, 37)},
       {9U, 4U, std::int64_t{0}, picoseconds(0), 1e300, "ok", true, BitView(raw_bytes, 0, 1)}}));
  EXPECT_EQ(file.size_of("cycle"), (std::vector<hsize_t>{1, 3}));
  EXPECT_EQ(file.numbers("cycle"), (std::vector<double>{7, 8, 9}));
  EXPECT_EQ(file.integers("wide"), (std::vector<std::uint64_t>{most - 1, 3, 4}));
  EXPECT_EQ(file.values<std::int64_t>("signed", H5T_NATIVE_INT64),
            (std::vector<std::int64_t>{-5, 9, 0}));
  EXPECT_EQ(file.numbers("time_ns"), (std::vector<double>{12500.125, -0.001, 0}));
  EXPECT_EQ(file.numbers("real"), (std::vector<double>{0.1, -2.5, 1e300}));
  EXPECT_EQ(file.integers("status"), (std::vector<std::uint64_t>{1, 2, 1}));
  EXPECT_EQ(file.integers("flag"), (std::vector<std::uint64_t>{1, 0, 1}));
  EXPECT_EQ(file.integers("raw"),
            (std::vector<std::uint64_t>{0x81, 0, 0, 0x23456789ABCDEF10, 0x102468ACF1, 1}));
  EXPECT_EQ(file.integers("raw_bits"), (std::vector<std::uint64_t>{72, 37, 1}));
  // A matrix of characters, column by column: "ok " and "crc".
  EXPECT_EQ(file.size_of("status_names"), (std::vector<hsize_t>{3, 2}));
  EXPECT_EQ(file.integers("status_names"),
            (std::vector<std::uint64_t>{'o', 'c', 'k', 'r', ' ', 'c'}));
  EXPECT_EQ(file.attribute("time_ns", "unit"), "ns");
  EXPECT_EQ(file.attribute("wide", "unit"), "counts");
  EXPECT_EQ(file.attribute("real", "unit"), "deg");
  EXPECT_EQ(file.attribute("cycle", "unit"), "none");
  EXPECT_EQ(file.attribute("cycle", "MATLAB_class"), "double");
  EXPECT_EQ(file.attribute("wide", "MATLAB_class"), "uint64");
  EXPECT_EQ(file.attribute("status_names", "MATLAB_class"), "char");
}

TEST(Hdf5, AbsentValue_IsNanOrTheAbsentValue) {
  const Content file(file_of(columns_of_each_kind(), {{}, {1U, 2U}}));
  EXPECT_TRUE(std::isnan(file.numbers("cycle")[0]));
  EXPECT_EQ(file.integers("wide")[0], std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(file.values<std::int64_t>("signed", H5T_NATIVE_INT64)[0],
            std::numeric_limits<std::int64_t>::min());
  EXPECT_TRUE(std::isnan(file.numbers("time_ns")[1]));
  EXPECT_TRUE(std::isnan(file.numbers("real")[1]));
  EXPECT_EQ(file.integers("status"), (std::vector<std::uint64_t>{0, 0}));
  EXPECT_EQ(file.integers("flag"), (std::vector<std::uint64_t>{255, 255}));
  EXPECT_EQ(file.integers("raw_bits"), (std::vector<std::uint64_t>{0, 0}));
  EXPECT_EQ(file.attribute("wide", "absent_value"), std::string(8, '\xFF'));
  EXPECT_EQ(file.attribute("flag", "absent_value"), "\xFF");
  EXPECT_EQ(file.attribute("cycle", "absent_value"), "none");
  EXPECT_FALSE(file.has("status_names"));
}

TEST(Hdf5, NoRows_IsAFileOfEmptyColumns) {
  const Content file(file_of(columns_of_each_kind(), {}));
  EXPECT_EQ(file.size_of("time_ns"), (std::vector<hsize_t>{1, 0}));
  EXPECT_EQ(file.size_of("raw"), (std::vector<hsize_t>{2, 0}));
}

TEST(Hdf5, FilesOfManyBlocks_HaveEveryRowAndNoSpaceForWhatIsAbsent) {
  for (const std::size_t count : {16383U, 16384U, 16385U, 32768U, 50000U}) {
    MemoryFile file;
    const auto writer = make_hdf5_writer(columns_of_each_kind(), file);
    for (std::size_t i = 0; i < count; ++i) {
      // The second block has no flag.
      const std::vector<Cell> row{i,
                                  i * i,
                                  Cell(),
                                  Cell(),
                                  Cell(),
                                  i % 3 == 0 ? "ok" : "crc",
                                  i / 16384 == 1 ? Cell() : Cell(true)};
      ASSERT_TRUE(writer->row(row));
    }
    ASSERT_TRUE(writer->finish());
    const Content content(file.bytes);
    const auto cycle = content.numbers("cycle");
    const auto wide = content.integers("wide");
    const auto status = content.integers("status");
    const auto flag = content.integers("flag");
    ASSERT_EQ(cycle.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_EQ(cycle[i], static_cast<double>(i));
      ASSERT_EQ(wide[i], i * i);
      ASSERT_EQ(status[i], i % 3 == 0 ? 1U : 2U);
      ASSERT_EQ(flag[i], i / 16384 == 1 ? 255U : 1U);
    }
    EXPECT_TRUE(std::isnan(content.numbers("time_ns").back()));
    EXPECT_EQ(content.bytes_of("time_ns"), 0U);
    if (count == 50000U) {
      EXPECT_EQ(content.bytes_of("flag"), 3U * 16384U);
    }
  }
}

TEST(Hdf5, SameRows_GiveTheSameFile) {
  const std::vector<std::vector<Cell>> rows{{1U, 2U, Cell(), Cell(), Cell(), "ok"}};
  EXPECT_EQ(file_of(columns_of_each_kind(), rows), file_of(columns_of_each_kind(), rows));
}

TEST(Hdf5, FirstBytes_AreTheHeaderOfMatlab73) {
  const auto bytes = file_of(columns_of_each_kind(), {{1U}});
  const std::string head(reinterpret_cast<const char*>(bytes.data()), 520);
  EXPECT_TRUE(head.starts_with("MATLAB 7.3 MAT-file"));
  EXPECT_EQ(head.substr(124, 4), std::string("\0\2IM", 4));
  EXPECT_EQ(head.substr(512), "\x89HDF\r\n\x1A\n");
}

TEST(Hdf5, TextBeyondAscii_IsUtf16) {
  const Content file(file_of({{.name = "file"}}, {{"µ😀"}, {"\xFF"}}));
  EXPECT_EQ(file.integers("file_names"),
            (std::vector<std::uint64_t>{0xB5, 0xFFFD, 0xD83D, ' ', 0xDE00, ' '}));
}

TEST(Hdf5, ValueThatDoesNotFitItsColumn_FailsAndSaysSo) {
  const auto cause_of = [](const Column& column, const Cell& cell) {
    MemoryFile file;
    const auto writer = make_hdf5_writer(std::vector{column}, file);
    EXPECT_FALSE(writer->row(std::vector{cell}));
    EXPECT_FALSE(writer->finish());
    return file.cause;
  };
  const std::string cause = "HDF5: a value does not fit its column";
  EXPECT_EQ(
      cause_of({.name = "n", .kind = Kind::unsigned_integer, .bits = 53}, std::uint64_t{1} << 53U),
      cause);
  EXPECT_EQ(cause_of({.name = "n", .kind = Kind::signed_integer, .bits = 20},
                     std::numeric_limits<std::int64_t>::min()),
            cause);
  EXPECT_EQ(cause_of({.name = "raw", .kind = Kind::bits, .bits = 64}, BitView(raw_bytes, 0, 65)),
            cause);
  EXPECT_EQ(cause_of({.name = "text", .kind = Kind::text}, 5U), cause);
}

// Whatever write fails, the caller learns it and nothing is left open.
TEST(Hdf5, FileThatIsFull_FailsTheRowsOrTheFinish) {
  MemoryFile whole;
  const auto write = [](MemoryFile& file) {
    const auto writer = make_hdf5_writer(columns_of_each_kind(), file);
    bool good = true;
    for (std::size_t i = 0; i < 40'000 && good; ++i) {
      good = writer->row(std::vector<Cell>{i, i, Cell(), picoseconds(5), 1.5, "ok", true,
                                           BitView(raw_bytes, 0, 72)});
    }
    return writer->finish() && good;
  };
  ASSERT_TRUE(write(whole));
  for (std::size_t most = 0; most < whole.bytes.size(); most += whole.bytes.size() / 37) {
    MemoryFile file(most);
    EXPECT_FALSE(write(file)) << most;
  }
  MemoryFile exact(whole.bytes.size());
  EXPECT_TRUE(write(exact));
  EXPECT_EQ(H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_ALL), 0);
}

}  // namespace hdf5_test
}  // namespace biss::report
