#include "verbs/common/files.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <optional>
#include <system_error>

#include "verbs/common/host.hpp"
#include "verbs/common/output.hpp"

namespace biss::verbs {
namespace {

namespace fs = std::filesystem;

// A file, or its future place in a folder.
struct Target {
  dev_t device{};
  ino_t inode{};
  std::string name;  // in the folder; empty for a file that exists

  bool operator==(const Target&) const = default;
};

bool is_standard(const NamedFile& file) { return file.path == "-"; }

std::optional<Target> target_of(const NamedFile& file, Host& host) {
  if (file.use == FileUse::read && host.capture(file.path) != nullptr) return std::nullopt;
  struct stat about {};
  if (is_standard(file) && file.use != FileUse::read && host.output() != nullptr) {
    return std::nullopt;
  }
  const int stream = file.use == FileUse::read ? STDIN_FILENO : STDOUT_FILENO;
  const bool exists =
      is_standard(file) ? ::fstat(stream, &about) == 0 : ::stat(file.path.c_str(), &about) == 0;
  if (exists && S_ISCHR(about.st_mode)) return std::nullopt;
  if (exists) return Target{about.st_dev, about.st_ino, {}};
  if (is_standard(file)) return std::nullopt;
  const fs::path path = follow_links(file.path);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (::stat(folder.c_str(), &about) != 0) return std::nullopt;
  return Target{about.st_dev, about.st_ino, path.filename().string()};
}

bool are_one(const NamedFile& a, const NamedFile& b, Host& host) {
  if (is_standard(a) && is_standard(b)) return (a.use == FileUse::read) == (b.use == FileUse::read);
  if (a.use == FileUse::read && b.use == FileUse::read) return false;
  const auto target = target_of(a, host);
  return target && target == target_of(b, host);
}

}  // namespace

std::string file_conflict(const std::vector<NamedFile>& files, Host& host) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    for (std::size_t k = i + 1; k < files.size(); ++k) {
      if (!are_one(files[i], files[k], host)) continue;
      return fmt::format("{} '{}' and {} '{}' are the same file; name another one", files[i].option,
                         files[i].path, files[k].option, files[k].path);
    }
  }
  return {};
}

bool names_a_descriptor(const std::string& path) {
  return path.starts_with("/proc/") || path.starts_with("/dev/fd/");
}

std::string follow_links(std::string path) {
  constexpr int most_links = 40;
  for (int i = 0; i < most_links; ++i) {
    std::error_code failed;
    const fs::path next = fs::read_symlink(path, failed);
    if (failed || names_a_descriptor(path)) return path;
    path = next.is_absolute() ? next.string() : (fs::path(path).parent_path() / next).string();
  }
  return {};
}

}  // namespace biss::verbs
