// Mutations of a ZIP archive that mostly leave a valid one: the members are changed and packed again,
// and sometimes the archive itself is changed.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fuzz/byte_mutator.hpp"
#include "fuzz/capture_seeds.hpp"
#include "fuzz/token_mutator.hpp"
#include "fuzz/zip_members.hpp"

namespace biss::fuzz {

class ZipMutator : public ByteMutator {
 public:
  explicit ZipMutator(std::uint64_t seed) : ByteMutator(seed) {}
  virtual ~ZipMutator() = default;

  /// Changes `archive` in one or two places, and replaces an invalid capture by a new seed.
  std::string mutate(std::string archive) {
    const std::uint64_t kind = below(16);
    if (kind == 1) return changed_header(std::move(archive));
    if (kind == 2) return changed_bytes(std::move(archive), 16);
    members_ = unpack_zip(archive, most_samples);
    if (kind == 0 || members_.size() < least_members()) new_members();
    change_member(kind);
    archive = ZipPacker(random_).pack(members_);
    return below(32) == 0 ? changed_header(std::move(archive)) : archive;
  }

 protected:
  // Larger members are not used for the next generation.
  static constexpr std::size_t most_samples = 1U << 16U;

  virtual std::size_t least_members() const = 0;
  virtual void new_members() = 0;
  virtual void change_member(std::uint64_t kind) = 0;

  // A member whose name begins with `begins`; any member if there is none.
  std::string& text_of(std::string_view begins) {
    const std::size_t first = below(members_.size());
    for (std::size_t i = 0; i < members_.size(); ++i) {
      ZipText& member = members_[(first + i) % members_.size()];
      if (member.name.starts_with(begins)) return member.text;
    }
    return members_[first].text;
  }

  std::vector<ZipText> members_;

 private:
  // Replaces a number in one of the headers or after it.
  std::string changed_header(std::string archive) {
    std::size_t at = archive.find("PK", below(archive.size()));
    if (at == std::string::npos) at = archive.rfind("PK");
    if (at == std::string::npos) return archive;
    at = std::min(at + below(48), archive.size());
    const std::size_t bytes = std::min<std::size_t>(1 + below(4), archive.size() - at);
    const std::uint64_t value = random_() >> below(64);
    for (std::size_t i = 0; i < bytes; ++i) archive[at + i] = static_cast<char>(value >> (8 * i));
    return archive;
  }
};

/// The custom mutator of a target that reads archives.
template <class Mutator>
std::size_t mutate_archive(std::uint8_t* data, std::size_t size, std::size_t max_size,
                           unsigned seed) {
  const std::string archive(reinterpret_cast<const char*>(data), size);
  return put_mutated(Mutator(seed).mutate(archive), archive, data, max_size);
}

}  // namespace biss::fuzz
