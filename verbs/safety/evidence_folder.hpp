// The files of an evidence bundle: written completely or not at all, and checked by their hashes.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "verbs/common/exit_status.hpp"

namespace biss::verbs {

struct EvidenceFile {
  std::string name;  ///< without a folder
  std::string text;
};

/// The name of the list of hashes, in the format of `sha256sum -c`.
inline constexpr const char* hash_list_name = "SHA256SUMS";

/// Returns the hash in lower-case hexadecimal.
std::string sha256_of(std::string_view text);

/// Returns the list for these files, in their order.
std::string hash_list(const std::vector<EvidenceFile>& files);

/// Returns the one line why the folder cannot be made, or nothing. Changes nothing.
/// \param replace an existing bundle may be replaced; a folder with any other file in it never is
std::string check_target(const std::string& folder, bool replace);

/// Writes the files and their hash_list() into a folder next to the target and renames it: the
/// target is the whole bundle, or unchanged. \return one line with the cause of an error, or
/// nothing
std::string write_bundle(const std::string& folder, const std::vector<EvidenceFile>& files,
                         bool replace);

/// A bundle on the disk.
struct ReadBundle {
  std::vector<EvidenceFile> files;
  /// A line for each file that is changed, missing, or not in the list of hashes.
  std::vector<std::string> findings;

  const EvidenceFile* find(std::string_view name) const;
};

/// The bundle, or one line with the cause why it cannot be read.
tl::expected<ReadBundle, std::string> read_bundle(const std::string& folder);

}  // namespace biss::verbs
