// The folder of an evidence bundle, and the hashes of its files.
#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "archive/listing.hpp"
#include "verbs/common/text_file.hpp"
#include "verbs/safety/evidence.hpp"

namespace biss::verbs {
namespace {

namespace fs = std::filesystem;

// Blocks signals while a folder with a temporary name exists, which is a short time.
class SignalsHeld {
 public:
  SignalsHeld() {
    sigset_t held;
    sigemptyset(&held);
    for (const int signal_number : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&held, signal_number);
    sigprocmask(SIG_BLOCK, &held, &before_);
  }
  ~SignalsHeld() { sigprocmask(SIG_SETMASK, &before_, nullptr); }
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;

 private:
  sigset_t before_{};
};

// A folder next to the target; the destructor removes it unless it has got the target's name.
class PartialFolder {
 public:
  explicit PartialFolder(const fs::path& target) : path_(target.string() + ".partial-XXXXXX") {
    if (::mkdtemp(path_.data()) == nullptr) {
      path_.clear();
      return;
    }
    const mode_t mask = ::umask(0);
    ::umask(mask);
    ::chmod(path_.c_str(), 0777 & ~mask);
  }
  ~PartialFolder() {
    std::error_code none;
    if (!path_.empty()) fs::remove_all(path_, none);
  }
  PartialFolder(const PartialFolder&) = delete;
  PartialFolder& operator=(const PartialFolder&) = delete;

  const std::string& path() const { return path_; }

  // Returns false and sets errno on failure. Removes an empty folder or a bundle of that name.
  bool take_name(const fs::path& target) {
    if (::rename(path_.c_str(), target.c_str()) == 0) {
      path_.clear();
      return true;
    }
    if (errno != ENOTEMPTY && errno != EEXIST) return false;
    // From here on path_ is the old bundle.
    return ::renameat2(AT_FDCWD, path_.c_str(), AT_FDCWD, target.c_str(), RENAME_EXCHANGE) == 0;
  }

 private:
  std::string path_;
};

std::string because(const std::string& what, int cause) {
  return fmt::format("cannot write '{}': {}", what, std::strerror(cause));
}

// With a trailing slash, the temporary folder would be inside the target instead of next to it.
fs::path target_of(const std::string& folder) {
  std::error_code none;
  const fs::path resolved = fs::weakly_canonical(folder, none);
  const fs::path target = none ? fs::path(folder) : resolved;
  return target.has_filename() ? target : target.parent_path();
}

std::string write_file(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  return file ? std::string() : because(path.string(), errno);
}

struct ListedHash {
  std::string name;
  std::string hash;
};

// Returns nothing unless every line is `HASH  NAME`.
std::optional<std::vector<ListedHash>> read_hash_list(const fs::path& folder) {
  constexpr std::size_t digits = 64;
  const std::string list = read_text_file(folder / hash_list_name).value_or("");
  std::vector<ListedHash> listed;
  for (std::string_view text = list; !text.empty();) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos || end < digits + 3 || text.substr(digits, 2) != "  ") {
      return std::nullopt;
    }
    listed.push_back({std::string(text.substr(digits + 2, end - digits - 2)),
                      std::string(text.substr(0, digits))});
    if (listed.back().name.find('/') != std::string::npos) return std::nullopt;
    text.remove_prefix(end + 1);
  }
  return listed.empty() ? std::nullopt : std::optional(std::move(listed));
}

// Whether the folder contains only the list and the files in the list.
bool is_bundle(const fs::path& folder, std::vector<std::string> names) {
  const auto listed = read_hash_list(folder);
  if (!listed) return false;
  for (const ListedHash& each : *listed) std::erase(names, each.name);
  std::erase(names, hash_list_name);
  return names.empty();
}

}  // namespace

std::string sha256_of(std::string_view text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1) {
    throw std::runtime_error("no SHA-256 in this machine's libcrypto");
  }
  std::string hash;
  for (unsigned i = 0; i < size; ++i) hash += fmt::format("{:02x}", digest[i]);
  return hash;
}

std::string check_target(const std::string& folder, bool replace) {
  const fs::path target = target_of(folder);
  std::error_code error;
  const fs::file_status status = fs::status(target, error);
  if (status.type() == fs::file_type::not_found) {
    const fs::path parent = target.has_parent_path() ? target.parent_path() : fs::path(".");
    if (::access(parent.c_str(), W_OK | X_OK) == 0) return {};
    return because(target.string(), errno);
  }
  if (status.type() != fs::file_type::directory) {
    return fmt::format("'{}' exists and is not a folder; name another one", folder);
  }
  const std::vector<std::string> names = archive::names_in(target, error);
  if (error) return because(target.string(), error.value());
  if (names.empty()) return {};
  const bool bundle = is_bundle(target, names);
  if (bundle && replace) return {};
  return fmt::format("'{}' is not empty; name another folder{}", folder,
                     bundle    ? ", or replace this bundle with --force"
                     : replace ? ": --force replaces bundles only"
                               : "");
}

std::string write_bundle(const std::string& folder, const std::vector<EvidenceFile>& files,
                         bool replace) {
  const SignalsHeld held;
  if (std::string wrong = check_target(folder, replace); !wrong.empty()) return wrong;
  const fs::path target = target_of(folder);
  PartialFolder partial(target);
  if (partial.path().empty()) return because(target.string(), errno);
  EvidenceFile hashes{hash_list_name, {}};
  for (const EvidenceFile& file : files) {
    std::string wrong = write_file(fs::path(partial.path()) / file.name, file.text);
    if (!wrong.empty()) return wrong;
    hashes.text += fmt::format("{}  {}\n", sha256_of(file.text), file.name);
  }
  std::string wrong = write_file(fs::path(partial.path()) / hashes.name, hashes.text);
  if (!wrong.empty()) return wrong;
  return partial.take_name(target) ? std::string() : because(target.string(), errno);
}

const EvidenceFile* ReadBundle::find(std::string_view name) const {
  const auto found = std::find_if(files.begin(), files.end(),
                                  [name](const EvidenceFile& file) { return file.name == name; });
  return found == files.end() ? nullptr : &*found;
}

tl::expected<ReadBundle, std::string> read_bundle(const std::string& folder) {
  ReadBundle bundle;
  std::error_code error;
  std::vector<std::string> names = archive::names_in(folder, error);
  if (error) {
    return tl::unexpected(fmt::format("cannot read '{}': {}", folder, error.message()));
  }
  const auto listed = read_hash_list(folder);
  if (!listed) {
    return tl::unexpected(fmt::format("'{}' is not a bundle: {} is missing or not a list of hashes",
                                      folder, hash_list_name));
  }
  std::erase(names, hash_list_name);
  for (const ListedHash& each : *listed) {
    std::erase(names, each.name);
    auto content = read_text_file(fs::path(folder) / each.name);
    if (!content) {
      bundle.findings.push_back(each.name + ": missing or unreadable: " + content.error());
      continue;
    }
    if (sha256_of(*content) != each.hash) {
      bundle.findings.push_back(each.name + ": another hash");
    }
    bundle.files.push_back({each.name, std::move(*content)});
  }
  for (const std::string& name : names) bundle.findings.push_back(name + ": not in the list");
  return bundle;
}

}  // namespace biss::verbs
