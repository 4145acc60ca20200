#include "archive/listing.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <set>
#include <system_error>
#include <tuple>
#include <utility>

#include "archive/hash.hpp"
#include "archive/summary.hpp"

namespace biss::archive {

namespace {

using Status = struct stat;

std::string reason(int cause) { return std::generic_category().message(cause); }

FileStamp stamp_of(const Status& status) {
  constexpr std::int64_t second_ns = 1'000'000'000;
  return {static_cast<std::uint64_t>(status.st_size),
          std::int64_t{status.st_mtim.tv_sec} * second_ns + status.st_mtim.tv_nsec};
}

// The path without links; empty if the path leads nowhere.
std::string real_path(const std::string& path) {
  std::error_code none;
  return std::filesystem::canonical(path, none).string();
}

std::string below(const std::string& folder, const std::string& name) {
  return folder.ends_with('/') ? folder + name : folder + '/' + name;
}

// The path as given, without `./` and the like. A path in which `..` follows a link is not changed,
// because the target of the link is in another place.
std::string plain_path(const std::string& path) {
  std::string plain = std::filesystem::path(path).lexically_normal();
  if (plain.size() > 1 && plain.ends_with('/')) plain.pop_back();
  return real_path(plain) == real_path(path) ? plain : path;
}

// Files and folders, without links. A list may name a million of them.
class Places {
 public:
  void add(std::string path) { paths_.insert(std::move(path)); }

  // One of them is the path, or a folder that it lies in.
  bool hold(std::string path) const {
    while (!paths_.contains(path)) {
      const std::size_t slash = path.rfind('/');
      if (slash == std::string::npos || path == "/") return false;
      path.resize(std::max(slash, std::size_t{1}));
    }
    return true;
  }
  // One of them lies in the folder.
  bool lie_in(const std::string& folder) const {
    const std::string begin = below(folder, "");
    const auto first = paths_.lower_bound(begin);
    return first != paths_.end() && first->starts_with(begin);
  }

 private:
  std::set<std::string> paths_;
};

std::string name_of_path(const std::string& path) {
  return path.substr(path.rfind('/') + 1);  // npos + 1 is 0
}

// Whether this program wrote the file, even an unfinished one.
bool is_own_file(const std::string& path, const Status& status) {
  const std::string name = name_of_path(path);
  if (name.starts_with(".biss-") && name.ends_with(".tmp")) return true;
  const bool journal = name.ends_with(".journal");
  if (!journal && !name.ends_with(".json")) return false;
  if (status.st_size == 0) return journal;
  std::string head(own_files_begin.size(), '\0');
  std::ifstream file(path, std::ios::binary);
  return file.read(head.data(), static_cast<std::streamsize>(head.size())) &&
         head == own_files_begin;
}

class Walk {
 public:
  // \param roots paths and, for each, the same without links
  explicit Walk(const std::vector<std::pair<std::string, std::string>>& roots) {
    for (const auto& [path, real] : roots) ends_.add(real);
    for (const auto& [path, real] : roots) begin(path);
    // Links to folders come first: their targets are known when a link to a file in them follows.
    while (!folder_links_.empty()) {
      follow_folder(folder_links_.extract(folder_links_.begin()).value());
    }
    for (const std::string& link : file_links_) follow_file(link);
  }

  std::vector<ListedFile> files() { return std::move(files_); }

 private:
  void leave_out(const std::string& path, const char* cause, const std::string& why) {
    files_.push_back({path, {}, cause, fmt::format("{}: {}", path, why)});
  }

  // The path may be a link.
  void begin(const std::string& path) {
    Status status{};
    if (::stat(path.c_str(), &status) != 0) return leave_out(path, "cannot_open", reason(errno));
    take(path, status);
  }

  void walk_folder(const std::string& folder) {
    std::error_code cause;
    const auto names = names_in(folder, cause);
    if (cause) return leave_out(folder, "folder_unreadable", cause.message());
    for (const std::string& name : names) {
      const std::string path = below(folder, name);
      Status status{};
      if (::lstat(path.c_str(), &status) != 0) {
        leave_out(path, "cannot_open", reason(errno));
      } else if (!S_ISLNK(status.st_mode)) {
        take(path, status);
      } else if (::stat(path.c_str(), &status) != 0) {
        leave_out(path, "broken_link", reason(errno));
      } else {
        (S_ISDIR(status.st_mode) ? folder_links_ : file_links_).insert(path);
      }
    }
  }

  void take(const std::string& path, const Status& status) {
    if (S_ISDIR(status.st_mode)) {
      walk_folder(path);
    } else if (!S_ISREG(status.st_mode)) {
      leave_out(path, "not_a_file", "a pipe, a socket or a device");
    } else if (!is_own_file(path, status)) {
      const std::string real = real_path(path);  // empty if it is gone by now
      files_.push_back({path, stamp_of(status), {}, {}, real.empty() ? 0 : hash_of(real)});
    }
  }

  void follow_folder(const std::string& link) {
    const std::string real = real_path(link);
    if (ends_.hold(real) || ends_.lie_in(real)) return leave_out(link, "link", read_elsewhere);
    ends_.add(real);
    begin(link);
  }

  void follow_file(const std::string& link) {
    const std::string real = real_path(link);
    if (ends_.hold(real) || !file_ends_.insert(real).second) {
      return leave_out(link, "link", read_elsewhere);
    }
    begin(link);
  }

  static constexpr const char* read_elsewhere = "a link to a file or folder that is read elsewhere";

  // The places that are read, without links: the given paths, and the folders and files that links
  // lead to.
  Places ends_;
  std::set<std::string> file_ends_;
  std::set<std::string> folder_links_;
  std::set<std::string> file_links_;
  std::vector<ListedFile> files_;
};

}  // namespace

std::vector<std::string> names_in(const std::string& folder, std::error_code& cause) {
  std::vector<std::string> names;
  for (std::filesystem::directory_iterator at(folder, cause), end; !cause && at != end;
       at.increment(cause)) {
    names.push_back(at->path().filename());
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool read_stamp(const std::string& path, FileStamp& stamp) {
  Status status{};
  if (::stat(path.c_str(), &status) != 0) return false;
  stamp = stamp_of(status);
  return true;
}

tl::expected<std::vector<ListedFile>, std::string> list_files(
    const std::vector<std::string>& paths, const std::vector<std::string>& listed) {
  std::vector<std::pair<std::string, std::string>> roots;
  std::error_code cause;
  for (const std::string& path : paths) {
    std::string real = std::filesystem::canonical(path, cause).string();
    if (cause) return tl::unexpected(fmt::format("{}: {}", path, cause.message()));
    roots.emplace_back(plain_path(path), std::move(real));
  }
  std::vector<ListedFile> gone;
  for (const std::string& path : listed) {
    std::string plain = plain_path(path);
    std::string real = std::filesystem::canonical(path, cause).string();
    if (cause) {
      gone.push_back({plain, {}, "cannot_open", fmt::format("{}: {}", plain, cause.message())});
    } else {
      roots.emplace_back(std::move(plain), std::move(real));
    }
  }
  // A folder with two names is read once, and so is a folder that is inside another one of the
  // list.
  std::sort(roots.begin(), roots.end(), [](const auto& a, const auto& b) {
    return std::tie(a.second, a.first) < std::tie(b.second, b.first);
  });
  Places places;
  std::vector<std::pair<std::string, std::string>> apart;
  for (auto& root : roots) {
    if (places.hold(root.second)) continue;
    places.add(root.second);
    apart.push_back(std::move(root));
  }
  std::vector<ListedFile> files = Walk(apart).files();
  files.insert(files.end(), gone.begin(), gone.end());
  // A link to nothing may be in a folder and in the list.
  std::stable_sort(files.begin(), files.end(),
                   [](const ListedFile& a, const ListedFile& b) { return a.path < b.path; });
  files.erase(
      std::unique(files.begin(), files.end(),
                  [](const ListedFile& a, const ListedFile& b) { return a.path == b.path; }),
      files.end());
  return files;
}

}  // namespace biss::archive
