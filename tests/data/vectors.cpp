#include "tests/data/vectors.hpp"

#include <fstream>
#include <stdexcept>

namespace published {

namespace {

std::string binary(std::uint64_t value, unsigned bits) {
  std::string text;
  for (unsigned i = bits; i-- > 0;) text += ((value >> i) & 1U) != 0 ? '1' : '0';
  return text;
}

// Splits at commas outside of quotes.
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

std::uint64_t hexadecimal(const std::string& text) { return std::stoull(text, nullptr, 16); }

Vector vector_of(const std::string& line) {
  const std::vector<std::string> fields = fields_of(line);
  if (fields.size() != 12) throw std::runtime_error("not 12 fields: " + line);
  const auto bits = static_cast<unsigned>(std::stoul(fields[2]));
  const auto crc_bits = static_cast<unsigned>(std::stoul(fields[7]));
  Vector vector;
  vector.name = fields[0];
  vector.position = hexadecimal(fields[3]);
  vector.crc = hexadecimal(fields[8]);
  vector.bits = binary(vector.position, bits);
  vector.format = fields[1].starts_with("SPW(MT12+ST20") ? "mt12,st20" : "pos" + fields[2];
  if (!fields[4].empty()) {
    vector.nE = fields[4] == "1";
    vector.nW = fields[5] == "1";
    vector.format += ",nE,nW";
    vector.bits += fields[4] + fields[5];
  }
  if (!fields[6].empty()) {
    vector.life_counter = hexadecimal(fields[6]);
    vector.format += ",lc6";
    vector.bits += binary(vector.life_counter, 6);
  }
  vector.format += ",crc" + fields[7] + ":" + fields[9];
  vector.bits += binary(vector.crc, crc_bits);
  return vector;
}

Vector log_vector_of(const std::string& line) {
  unsigned mt = 0;
  unsigned st = 0;
  unsigned flags = 0;
  unsigned crc = 0;
  if (std::sscanf(line.c_str(), "MT:0x%x, ST:0x%x, EW:0x%x, CRC:0x%x", &mt, &st, &flags, &crc) !=
      4) {
    throw std::runtime_error("not a line of the log: " + line);
  }
  Vector vector;
  vector.name = line;
  vector.format = "mt12,st12,nE,nW,crc6";
  vector.position = (std::uint64_t{mt} << 12U) | st;
  vector.nE = (flags & 2U) != 0;
  vector.nW = (flags & 1U) != 0;
  vector.crc = crc;
  vector.bits = binary(mt, 12) + binary(st, 12) + binary(flags, 2) + binary(crc, 6);
  return vector;
}

File read(const std::string& path, Vector (*parse)(const std::string&)) {
  std::ifstream input(path);
  if (!input) throw std::runtime_error("cannot read " + path);
  File file;
  for (std::string line; std::getline(input, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    ++file.data_lines;
    file.vectors.push_back(parse(line));
  }
  return file;
}

}  // namespace

File read_vectors(const std::string& path) { return read(path, vector_of); }
File read_slave_log(const std::string& path) { return read(path, log_vector_of); }

}  // namespace published
