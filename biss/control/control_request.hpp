// What a control session is asked to do, the CDM bits that say it, and what the answers mean for
// it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "biss/control/control_answer.hpp"
#include "biss/control/control_error.hpp"
#include "biss/control/control_frame.hpp"
#include "biss/control/control_outcome.hpp"

namespace biss {

enum class ControlKind : std::uint8_t { read, write, addressed, broadcast };

/// One access. Made by the four functions below; `possible` tells whether a control frame can say
/// it.
struct ControlRequest {
  ControlKind kind = ControlKind::read;
  ExecuteIf execute_if = ExecuteIf::all_accept;
  /// Bit k: the slave with ID k is addressed. 0: all are meant.
  std::uint8_t slaves = 0;
  /// Bytes to read or write.
  std::uint8_t size = 0;
  bool possible = false;
  /// Of the first byte, see register_header() and command_header().
  std::uint16_t header = 0;
  std::uint8_t* to = nullptr;
  const std::uint8_t* from = nullptr;

  /// The CDM bits up to S of the first byte or to EX = 1, the first one topmost; zeros behind them.
  /// \param bytes_done of a sequential access that goes on: how many bytes are to be skipped
  constexpr std::uint32_t first_bits(unsigned bytes_done) const {
    const auto here = static_cast<std::uint16_t>(header + bytes_done);
    return 1U << 31U | std::uint32_t{here} << 20U | std::uint32_t{header_crc(here)} << 16U | tail();
  }

  /// Why the access cannot go on after CDS bits 0…15, bit 0 topmost; who is there goes into
  /// `outcome`.
  constexpr std::optional<ControlError> judge_ids(std::uint16_t cds,
                                                  ControlOutcome& outcome) const {
    const auto count = slaves_counted(cds);
    if (!count) return ControlError::id_pattern;
    if (*count == 0) return ControlError::no_answer;
    outcome.more_slaves = *count > control_max_slaves;
    outcome.slaves_present = static_cast<std::uint8_t>((1U << *count) - 1U);
    if (!enough(outcome.slaves_present)) return ControlError::no_such_slave;
    return std::nullopt;
  }

  /// Why a register access cannot go on after R and W, W lowest.
  constexpr std::optional<ControlError> judge_access(std::uint16_t cds) const {
    const auto access = kind == ControlKind::read ? RegisterAccess::read : RegisterAccess::write;
    return access_denied(access, (cds & 2U) != 0, (cds & 1U) != 0);
  }

  /// Why a command is to be dropped after CDS bits 16…23, bit 23 lowest; who accepts it goes into
  /// `outcome`.
  constexpr std::optional<ControlError> judge_ida(std::uint16_t cds,
                                                  ControlOutcome& outcome) const {
    outcome.accepted = slaves_accepting(static_cast<std::uint8_t>(cds & 0xFFU));
    if (execute_if == ExecuteIf::always) return std::nullopt;
    if ((outcome.accepted | slaves) != slaves) return ControlError::ida_pattern;
    if (!enough(outcome.accepted)) return ControlError::not_accepted;
    return std::nullopt;
  }

 private:
  constexpr bool enough(std::uint8_t those) const {
    const unsigned addressed = those & slaves;
    return execute_if == ExecuteIf::all_accept ? addressed == slaves : addressed != 0;
  }

  constexpr std::uint32_t tail() const {
    switch (kind) {
      case ControlKind::read:
        return 0b101U << 13U;  // R, W, S
      case ControlKind::write:
        return 0b011U << 13U;
      case ControlKind::addressed:
        return 0b1'0000000'1U << 7U;  // S, while IDA comes, EX
      case ControlKind::broadcast:
        return 0b11U << 14U;  // S, EX
    }
    return 0;
  }
};

namespace control_detail {

constexpr ControlRequest register_request(ControlKind kind, unsigned slave, unsigned address,
                                          std::size_t size) {
  return {.kind = kind,
          .slaves = static_cast<std::uint8_t>(1U << (slave & 7U)),
          .size = static_cast<std::uint8_t>(size),
          .possible = slave < control_max_slaves && size >= 1 && size <= sequential_max_bytes &&
                      address < register_count && size <= register_count - address,
          .header = register_header(slave, address)};
}

}  // namespace control_detail

constexpr ControlRequest read_request(unsigned slave, unsigned address,
                                      std::span<std::uint8_t> to) {
  auto request = control_detail::register_request(ControlKind::read, slave, address, to.size());
  request.to = to.data();
  return request;
}

constexpr ControlRequest write_request(unsigned slave, unsigned address,
                                       std::span<const std::uint8_t> from) {
  auto request = control_detail::register_request(ControlKind::write, slave, address, from.size());
  request.from = from.data();
  return request;
}

constexpr ControlRequest command_request(std::uint8_t slaves, ControlCommand command,
                                         ExecuteIf execute_if) {
  return {.kind = ControlKind::addressed,
          .execute_if = execute_if,
          .slaves = slaves,
          .possible = slaves != 0,
          .header = command_header(slaves, command)};
}

constexpr ControlRequest broadcast_request(ControlCommand command) {
  return {.kind = ControlKind::broadcast, .possible = true, .header = command_header(0, command)};
}

}  // namespace biss
