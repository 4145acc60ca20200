// The files of an evidence bundle: made as a whole or not at all, and held against their hashes.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/common/exit_status.hpp"

namespace biss::cli {

struct EvidenceFile {
  std::string name;  ///< without a folder
  std::string text;
};

/// Name of the list of hashes, which `sha256sum -c` takes.
inline constexpr const char* hash_list_name = "SHA256SUMS";

/// In lower-case hexadecimal.
std::string sha256_of(std::string_view text);

/// The list for these files, in their order.
std::string hash_list(const std::vector<EvidenceFile>& files);

/// Whether a folder may be made there; else one line that says why not. Nothing is changed.
/// \param replace a bundle that stands there may go; a folder with any other file in it never
std::string check_target(const std::string& folder, bool replace);

/// Writes the files and their hash_list() into a folder beside it and gives that its name: there is
/// the whole bundle, or what was there before. \return one line why not, or nothing
std::string write_bundle(const std::string& folder, const std::vector<EvidenceFile>& files,
                         bool replace);

/// A bundle as it stands on the disk, or one line that says why it cannot be read.
struct ReadBundle {
  std::vector<EvidenceFile> files;
  /// Lines about what is not as the list of hashes says: another content, missing, in excess.
  std::vector<std::string> findings;
  std::string error;

  const EvidenceFile* find(std::string_view name) const;
};

ReadBundle read_bundle(const std::string& folder);

}  // namespace biss::cli
