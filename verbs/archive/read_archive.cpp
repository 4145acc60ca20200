// Reads the captures of an archive into its journal, with progress and interruption.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "archive/entry.hpp"
#include "archive/summary.hpp"
#include "lab/experiment.hpp"
#include "verbs/archive/archive.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/journal.hpp"
#include "verbs/common/output.hpp"
#include "verbs/common/terminal.hpp"

namespace biss::verbs {

namespace {

using archive::FileEntry;
using archive::ListedFile;

struct ArchiveProgress {
  std::uint64_t files = 0;
  std::uint64_t all_files = 0;
  std::uint64_t bytes = 0;
  std::uint64_t all_bytes = 0;
};

std::string volume_text(std::uint64_t bytes) {
  return fmt::format("{:.2f}", static_cast<double>(bytes) * 1e-9);
}

class ArchiveRun {
 public:
  ArchiveRun(const ArchiveTask& task, Host& host) : task_(task), host_(host), journal_(host) {}

  archive::Summary run(const std::vector<ListedFile>& files) {
    summary_.setup = task_.setup;
    summary_.parts = {.count = task_.shard.count, .done = {task_.shard.number}};
    for (std::size_t i = 0; i < files.size(); ++i) {
      summary_.list.add(archive::utf8_text(files[i].path));
      if (i % task_.shard.count == task_.shard.number - 1) add_file(files[i]);
    }
    if (!task_.journal.empty()) open_journal();
    read_rest();
    return std::move(summary_);
  }

 private:
  void add_file(const ListedFile& file) {
    ++now_.all_files;
    now_.all_bytes += file.stamp.bytes;
    if (file.cause.empty()) {
      waiting_.emplace(archive::utf8_text(file.path), &file);
    } else {
      take(read_listed_file(file, task_.capture, 1, host_), file);
    }
  }

  void take(FileEntry entry, const ListedFile& file) {
    ++now_.files;
    now_.bytes += file.stamp.bytes;
    entry.place = file.place;
    summary_.add(std::move(entry));
  }

  void open_journal() {
    const auto use = [this](std::string_view line) {
      auto stamped = archive::read_journal_line(line);
      if (!stamped) return false;
      const auto at = waiting_.find(stamped->entry.path);
      if (at == waiting_.end() || at->second->stamp != stamped->stamp) return false;
      take(std::move(stamped->entry), *at->second);
      waiting_.erase(at);
      return true;
    };
    journal_.open(task_.journal,
                  {.owner = "biss archive",
                   .begins = std::string(archive::own_files_begin),
                   .header = archive::journal_header(task_.setup)},
                  use);
  }

  // The largest first: no thread is left with a large one when the others are done.
  std::vector<const ListedFile*> files_by_size() const {
    std::vector<const ListedFile*> files;
    for (const auto& [path, file] : waiting_) files.push_back(file);
    std::sort(files.begin(), files.end(), [](const ListedFile* a, const ListedFile* b) {
      if (a->stamp.bytes != b->stamp.bytes) return a->stamp.bytes > b->stamp.bytes;
      return a->path < b->path;
    });
    return files;
  }

  void read_rest() {
    const auto files = files_by_size();
    before_ = now_;
    progress_.emplace(host_);
    const unsigned threads =
        task_.threads != 0 ? task_.threads : std::max(1U, std::thread::hardware_concurrency());
    std::size_t next = 0;
    std::uint64_t left = now_.all_bytes - now_.bytes;
    while (next < files.size() && is_for_all_threads(*files[next], left, threads)) {
      const ListedFile& file = *files[next++];
      left -= file.stamp.bytes;
      read(file, threads);
    }
    lab::run_workers(threads, [&] {
      std::unique_lock lock(mutex_);
      if (next == files.size()) return false;
      const ListedFile& file = *files[next++];
      lock.unlock();
      read(file, 1);
      return true;
    });
  }

  // A file so long that one thread would still read it when the others have read the rest.
  static bool is_for_all_threads(const ListedFile& file, std::uint64_t left, unsigned threads) {
    constexpr std::uint64_t worth_threads = std::uint64_t{1} << 20U;
    return file.stamp.bytes >= worth_threads && file.stamp.bytes > left / threads;
  }

  void read(const ListedFile& file, unsigned threads) {
    archive::StampedEntry stamped{file.stamp,
                                  read_listed_file(file, task_.capture, threads, host_)};
    const std::lock_guard lock(mutex_);
    if (!task_.journal.empty() && is_lasting(stamped.entry))
      journal_.append(archive::journal_line(stamped));
    take(std::move(stamped.entry), file);
    if (progress_->due()) progress_->show(text_of_progress());
  }

  // `312 of 1000 files, 1.2 of 4.5 GB, 85.3 files/s, 210.00 MB/s, 0:12 left`.
  std::string text_of_progress() const {
    const double seconds = progress_->seconds();
    const double files = static_cast<double>(now_.files - before_.files) / seconds;
    const double bytes = static_cast<double>(now_.bytes - before_.bytes) / seconds;
    // The bytes determine the time for large files, the number for small ones: whichever is longer.
    const double by_files = static_cast<double>(now_.all_files - now_.files) / files;
    const double by_bytes =
        bytes > 0 ? static_cast<double>(now_.all_bytes - now_.bytes) / bytes : 0;
    return fmt::format("{} of {} files, {} of {} GB", now_.files, now_.all_files,
                       volume_text(now_.bytes), volume_text(now_.all_bytes)) +
           rate_text(files, "files") + rate_text(bytes, "B") +
           left_text(std::max(by_files, by_bytes));
  }

  const ArchiveTask& task_;
  archive::Summary summary_;
  Host& host_;
  Journal journal_;
  // The files to read, by the path in their entries.
  std::unordered_map<std::string, const ListedFile*> waiting_;
  ArchiveProgress now_;
  // When reading began.
  ArchiveProgress before_;
  std::optional<Progress> progress_;
  std::mutex mutex_;
};

}  // namespace

archive::Summary read_archive(const ArchiveTask& task, const std::vector<ListedFile>& files,
                              Host& host) {
  return ArchiveRun(task, host).run(files);
}

}  // namespace biss::verbs
