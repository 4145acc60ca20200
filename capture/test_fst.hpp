// FST files for tests: made of parts, and taken apart again. Nothing in them is compressed.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "capture/fst_file.hpp"
#include "wire/edge.hpp"

namespace biss::capture {

inline void put_varint(std::string& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7U) out += static_cast<char>(value | 0x80U);
  out += static_cast<char>(value);
}

inline void put_big_endian(std::string& out, std::uint64_t value) {
  for (int shift = 56; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift);
}

struct FstPartsBlock {
  std::uint8_t kind = 8;
  std::uint64_t begin = 0;
  std::string frame;
  char packing = '4';
  std::string chains;  ///< after the letter of the packing
  std::string index;
  std::string times;
  std::uint64_t times_count = 0;
};

struct FstParts {
  std::int8_t exponent = -12;
  std::vector<FstPartsBlock> blocks;
  std::string geometry;
  std::uint64_t handles = 0;
  std::string blackouts;  ///< the section is left out if this is empty
  std::string hierarchy;
};

/// Text as LZ4 that is nothing but literals.
inline std::string lz4_literals(std::string_view text) {
  std::string out;
  std::size_t left = text.size();
  out += static_cast<char>(std::min<std::size_t>(left, 15) << 4U);
  if (left >= 15) {
    for (left -= 15; left >= 255; left -= 255) out += '\xFF';
    out += static_cast<char>(left);
  }
  return out += text;
}

inline std::string fst_section(std::uint8_t kind, std::string_view content) {
  std::string out(1, static_cast<char>(kind));
  put_big_endian(out, content.size() + 8);
  return out += content;
}

inline std::string fst_header(std::int8_t exponent) {
  std::string content(16, '\0');
  content += "\x69\x57\x14\x8B\x0A\xBF\x05\x40";
  content += std::string(40, '\0');
  content += static_cast<char>(exponent);
  return fst_section(0, content += std::string(256, '\0'));
}

inline std::string fst_block(const FstPartsBlock& block) {
  std::string content;
  put_big_endian(content, block.begin);
  put_big_endian(content, block.begin);
  put_big_endian(content, 0);
  put_varint(content, block.frame.size());
  put_varint(content, block.frame.size());
  put_varint(content, 0);
  content += block.frame;
  put_varint(content, 0);
  content += block.packing;
  content += block.chains + block.index;
  put_big_endian(content, block.index.size());
  content += block.times;
  put_big_endian(content, block.times.size());
  put_big_endian(content, block.times.size());
  put_big_endian(content, block.times_count);
  return fst_section(block.kind, content);
}

inline std::string fst_hierarchy(std::string_view hierarchy) {
  std::string content;
  put_big_endian(content, hierarchy.size());
  return fst_section(6, content + lz4_literals(hierarchy));
}

inline std::string fst_of(const FstParts& parts) {
  std::string out = fst_header(parts.exponent);
  for (const FstPartsBlock& block : parts.blocks) out += fst_block(block);
  std::string geometry;
  put_big_endian(geometry, parts.geometry.size());
  put_big_endian(geometry, parts.handles);
  out += fst_section(3, geometry + parts.geometry);
  if (!parts.blackouts.empty()) out += fst_section(2, parts.blackouts);
  return out + fst_hierarchy(parts.hierarchy);
}

/// A variable of one bit in the hierarchy; `alias` is a handle, 0: it has its own.
inline std::string fst_variable(std::string_view name, std::uint64_t alias = 0) {
  std::string out("\x10\0", 2);
  out += name;
  out += std::string("\0\1", 2);
  put_varint(out, alias);
  return out;
}

/// The block of these edges, whose ticks count from `begin`; index and aliases are in the form of
/// DYN_ALIAS2. Every line is a handle.
inline FstPartsBlock fst_block_of(const std::vector<wire::Edge>& edges, std::size_t lines,
                                  std::uint64_t begin) {
  FstPartsBlock block;
  block.begin = begin;
  block.frame.assign(lines, 'x');
  std::vector<std::string> chains(lines);
  std::vector<std::uint64_t> last_index(lines);
  std::uint64_t tick = 0;
  for (const wire::Edge& edge : edges) {
    const auto now = static_cast<std::uint64_t>(edge.time.count);
    if (block.times_count == 0 || now != tick) {
      put_varint(block.times, now - tick);
      ++block.times_count;
      tick = now;
    }
    const std::uint64_t delta = block.times_count - 1 - last_index[edge.line];
    last_index[edge.line] = block.times_count - 1;
    const bool known = edge.level != wire::Level::unknown;
    put_varint(chains[edge.line], known ? delta << 2U | (edge.level == wire::Level::high ? 2U : 0U)
                                        : delta << 4U | 1U);
  }
  std::uint64_t step = 1;
  for (const std::string& chain : chains) {
    if (chain.empty()) {
      put_varint(block.index, 2);
      continue;
    }
    // A signed number: the sign is bit 6 of the last byte.
    const std::uint64_t code = step << 1U | 1U;
    std::string number;
    put_varint(number, code);
    if ((static_cast<unsigned char>(number.back()) & 0x40U) != 0) {
      number.back() = static_cast<char>(static_cast<unsigned char>(number.back()) | 0x80U);
      number += '\0';
    }
    block.index += number;
    block.chains += '\0' + chain;
    step = chain.size() + 1;
  }
  return block;
}

/// Edges as one block, in picoseconds.
inline FstParts fst_parts_of(const std::vector<std::string>& names,
                             const std::vector<wire::Edge>& edges) {
  FstParts parts;
  parts.blocks.push_back(fst_block_of(edges, names.size(), 0));
  parts.geometry = std::string(names.size(), '\1');
  parts.handles = names.size();
  parts.hierarchy = std::string("\xFE\0top\0\0", 7);
  for (const std::string& name : names) parts.hierarchy += fst_variable(name);
  parts.hierarchy += '\xFF';
  return parts;
}

}  // namespace biss::capture
