// Who has which ID in this control frame: told by the bits IDL0 … IDL8 on CDS.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "biss/control/control_frame.hpp"

namespace biss::slave_detail {

/// The IDs of one device. A slave without one that sees 0 at IDL index k takes ID k and makes it 1;
/// one that sees 1 waits. Assigned anew in every control frame (D2).
template <unsigned Ids>
class IdAssignment {
  static_assert(Ids >= 1 && Ids <= control_max_slaves);

 public:
  constexpr void begin() {
    slave_of_.fill(none);
    next_ = 0;
    skip_silent();
  }

  /// The bit to send at this index, 0 … 8. \param predecessor the bit that came at it
  constexpr bool take(unsigned index, bool predecessor) {
    if (predecessor) return true;
    if (index >= control_max_slaves) return next_ < Ids;  // IDL8: there are more
    if (slave_of_[index] != none) return true;
    if (next_ == Ids) return false;
    slave_of_[index] = next_++;
    skip_silent();
    return true;
  }

  /// The device's slave with this ID.
  constexpr std::optional<unsigned> slave_of(unsigned id) const {
    if (slave_of_[id] == none) return std::nullopt;
    return slave_of_[id];
  }

  /// A silent slave takes no ID, from the next control frame on.
  constexpr void silence(unsigned slave) {
    silent_ = static_cast<std::uint8_t>(silent_ | 1U << slave);
  }
  constexpr void admit_all() { silent_ = 0; }
  constexpr bool is_silent(unsigned slave) const { return (silent_ >> slave & 1U) != 0; }

 private:
  static constexpr std::uint8_t none = 0xFF;

  constexpr void skip_silent() {
    while (next_ < Ids && is_silent(next_)) ++next_;
  }

  std::array<std::uint8_t, control_max_slaves> slave_of_{};
  std::uint8_t next_ = 0;  // the slave that takes the next ID
  std::uint8_t silent_ = 0;
};

}  // namespace biss::slave_detail
