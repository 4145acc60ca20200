// How the struct of a part and its bank become each other: member by member in address order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/eds/bank.hpp"
#include "biss/eds/field.hpp"

namespace biss::eds_detail {

// `part.members(visit)` names every member in the order of the addresses; a member's type says how
// many bytes it has.
template <class Part>
constexpr Part parsed(const EdsBank& bank) {
  Part part;
  std::size_t at = 0;
  Part::members(part, [&]<class Member>(Member& member) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < sizeof(Member); ++i) value = value << 8U | bank[at++];
    member = static_cast<Member>(value);
  });
  return part;
}

template <class Part>
constexpr EdsBank built(const Part& part) {
  EdsBank bank{};
  std::size_t at = 0;
  Part::members(part, [&]<class Member>(const Member& member) {
    for (std::size_t i = sizeof(Member); i-- > 0;) {
      bank[at++] = static_cast<std::uint8_t>(member >> (8U * i));
    }
  });
  return bank;
}

// Whether struct and table agree on every boundary.
template <class Part>
constexpr bool matches(std::span<const EdsField> fields) {
  const Part part{};
  std::size_t row = 0;
  std::size_t at = 0;
  bool same = true;
  Part::members(part, [&]<class Member>(const Member&) {
    same = same && row < fields.size() && fields[row].address == at &&
           fields[row].bytes == sizeof(Member);
    ++row;
    at += sizeof(Member);
  });
  return same && row == fields.size() && at == eds_bank_bytes && covers_the_bank(fields);
}

}  // namespace biss::eds_detail
