// The folder of an evidence bundle, and the hashes of its files.
#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
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
#include <span>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "archive/listing.hpp"
#include "verbs/common/text_file.hpp"
#include "verbs/safety/evidence.hpp"

namespace biss::verbs {
namespace {

namespace fs = std::filesystem;

VerbError cannot_write(const fs::path& path, int cause) {
  return wrong_file("cannot write '{}': {}", path.string(), std::strerror(cause));
}

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
    if (::mkdtemp(path_.data()) == nullptr) throw cannot_write(target, errno);
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

  fs::path path() const { return path_; }

  // Removes an empty folder or a bundle of that name.
  void take_name(const fs::path& target) {
    if (::rename(path_.c_str(), target.c_str()) == 0) return path_.clear();
    // Once they have changed places, path_ is the old bundle.
    const bool may_exchange = errno == ENOTEMPTY || errno == EEXIST;
    if (!may_exchange ||
        ::renameat2(AT_FDCWD, path_.c_str(), AT_FDCWD, target.c_str(), RENAME_EXCHANGE) != 0) {
      throw cannot_write(target, errno);
    }
  }

 private:
  std::string path_;
};

// With a trailing slash, the temporary folder would be inside the target instead of next to it.
fs::path target_of(const std::string& folder) {
  std::error_code none;
  const fs::path resolved = fs::weakly_canonical(folder, none);
  const fs::path target = none ? fs::path(folder) : resolved;
  return target.has_filename() ? target : target.parent_path();
}

void write_file(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw cannot_write(path, errno);
}

// The names of files and their hashes.
using ListedHashes = std::vector<std::pair<std::string, std::string>>;

// Returns nothing unless every line is `HASH  NAME`.
std::optional<ListedHashes> read_hash_list(const fs::path& folder) {
  constexpr std::size_t digits = 64;
  const std::string list = read_text_file(folder / hash_list_name).value_or("");
  if (!list.ends_with('\n')) return std::nullopt;
  ListedHashes listed;
  std::istringstream lines(list);
  for (std::string line; std::getline(lines, line);) {
    if (line.size() < digits + 3 || line.compare(digits, 2, "  ") != 0) return std::nullopt;
    if (line.find('/', digits) != std::string::npos) return std::nullopt;
    listed.emplace_back(line.substr(digits + 2), line.substr(0, digits));
  }
  return listed;
}

// Whether the folder contains only the list and the files in the list.
bool is_bundle(const fs::path& folder, std::vector<std::string> names) {
  const auto listed = read_hash_list(folder);
  if (!listed) return false;
  for (const auto& [name, hash] : *listed) std::erase(names, name);
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
  return fmt::format("{:02x}", fmt::join(std::span(digest).first(size), ""));
}

void check_target(const std::string& folder, bool replace) {
  const fs::path target = target_of(folder);
  std::error_code error;
  const fs::file_status status = fs::status(target, error);
  if (status.type() == fs::file_type::not_found) {
    const fs::path parent = target.has_parent_path() ? target.parent_path() : fs::path(".");
    if (::access(parent.c_str(), W_OK | X_OK) != 0) throw cannot_write(target, errno);
    return;
  }
  if (status.type() != fs::file_type::directory) {
    throw wrong_file("'{}' exists and is not a folder; name another one", folder);
  }
  const std::vector<std::string> names = archive::names_in(target, error);
  if (error) throw cannot_write(target, error.value());
  const bool bundle = is_bundle(target, names);
  if (names.empty() || (bundle && replace)) return;
  throw wrong_file("'{}' is not empty; name another folder{}", folder,
                   bundle    ? ", or replace this bundle with --force"
                   : replace ? ": --force replaces bundles only"
                             : "");
}

void write_bundle(const std::string& folder, const std::vector<EvidenceFile>& files, bool replace) {
  const SignalsHeld held;
  check_target(folder, replace);
  const fs::path target = target_of(folder);
  PartialFolder partial(target);
  std::string hashes;
  for (const EvidenceFile& file : files) {
    write_file(partial.path() / file.name, file.text);
    hashes += fmt::format("{}  {}\n", sha256_of(file.text), file.name);
  }
  write_file(partial.path() / hash_list_name, hashes);
  partial.take_name(target);
}

const EvidenceFile* ReadBundle::find(std::string_view name) const {
  const auto found = std::find_if(files.begin(), files.end(),
                                  [name](const EvidenceFile& file) { return file.name == name; });
  return found == files.end() ? nullptr : &*found;
}

ReadBundle read_bundle(const std::string& folder) {
  ReadBundle bundle;
  std::error_code error;
  std::vector<std::string> names = archive::names_in(folder, error);
  if (error) throw wrong_file("cannot read '{}': {}", folder, error.message());
  const auto listed = read_hash_list(folder);
  if (!listed) {
    throw wrong_file("'{}' is not a bundle: {} is missing or not a list of hashes", folder,
                     hash_list_name);
  }
  std::erase(names, hash_list_name);
  for (const auto& [name, hash] : *listed) {
    std::erase(names, name);
    auto content = read_text_file(fs::path(folder) / name);
    if (!content) {
      bundle.findings.push_back(name + ": missing or unreadable: " + content.error());
      continue;
    }
    if (sha256_of(*content) != hash) bundle.findings.push_back(name + ": another hash");
    bundle.files.push_back({name, std::move(*content)});
  }
  for (const std::string& name : names) bundle.findings.push_back(name + ": not in the list");
  return bundle;
}

}  // namespace biss::verbs
