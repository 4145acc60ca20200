// Reads the captures of an archive into its journal, with progress and interruption.
#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <thread>
#include <unordered_map>
#include <utility>

#include "lab/experiment.hpp"
#include "verbs/archive/archive.hpp"
#include "verbs/archive/journal.hpp"
#include "verbs/common/terminal.hpp"

namespace biss::verbs {

namespace {

using archive::FileEntry;
using archive::ListedFile;

std::string volume_text(std::uint64_t bytes) {
  return fmt::format("{:.2f}", static_cast<double>(bytes) * 1e-9);
}

class ArchiveRun {
 public:
  ArchiveRun(const ArchiveTask& task, archive::Summary& summary, Host& host)
      : task_(task), summary_(summary), host_(host), journal_(host) {}

  ExitStatus run(const std::vector<ListedFile>& files) {
    summary_.setup = task_.setup;
    summary_.parts = {.count = task_.shard.count, .done = {task_.shard.number}};
    for (std::size_t i = 0; i < files.size(); ++i) {
      summary_.list.add(archive::utf8_text(files[i].path));
      if (i % task_.shard.count == task_.shard.number - 1) add_file(files[i]);
    }
    if (!task_.journal.empty()) {
      const ExitStatus status = open_journal();
      if (status != ExitStatus::done) return status;
    }
    return read_rest();
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

  ExitStatus open_journal() {
    const auto use = [this](archive::StampedEntry stamped) {
      const auto at = waiting_.find(stamped.entry.path);
      if (at == waiting_.end() || at->second->stamp != stamped.stamp) return false;
      take(std::move(stamped.entry), *at->second);
      waiting_.erase(at);
      return true;
    };
    return journal_.open(task_.journal, archive::journal_header(task_.setup), use);
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

  ExitStatus read_rest() {
    const auto files = files_by_size();
    before_ = now_;
    progress_.emplace(host_);
    const unsigned threads =
        task_.threads != 0 ? task_.threads : std::max(1U, std::thread::hardware_concurrency());
    std::size_t next = 0;
    std::uint64_t left = now_.all_bytes - now_.bytes;
    while (next < files.size() && status_ == ExitStatus::done &&
           is_for_all_threads(*files[next], left, threads)) {
      const ListedFile& file = *files[next++];
      left -= file.stamp.bytes;
      read(file, threads);
    }
    lab::run_workers(threads, [&] {
      std::unique_lock lock(mutex_);
      if (next == files.size() || status_ != ExitStatus::done) return false;
      const ListedFile& file = *files[next++];
      lock.unlock();
      read(file, 1);
      return true;
    });
    return status_;
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
    if (!task_.journal.empty() && is_lasting(stamped.entry)) {
      status_ = std::max(status_, journal_.append(stamped));
    }
    take(std::move(stamped.entry), file);
    if (progress_->due()) progress_->show(progress_text(now_, before_, progress_->seconds()));
  }

  const ArchiveTask& task_;
  archive::Summary& summary_;
  Host& host_;
  Journal journal_;
  // The files to read, by the path in their entries.
  std::unordered_map<std::string, const ListedFile*> waiting_;
  ArchiveProgress now_;
  // When reading began.
  ArchiveProgress before_;
  std::optional<Progress> progress_;
  std::mutex mutex_;
  ExitStatus status_ = ExitStatus::done;
};

}  // namespace

std::string progress_text(const ArchiveProgress& now, const ArchiveProgress& before,
                          double seconds) {
  const double files = static_cast<double>(now.files - before.files) / seconds;
  const double bytes = static_cast<double>(now.bytes - before.bytes) / seconds;
  std::string text = fmt::format("{} of {} files, {} of {} GB", now.files, now.all_files,
                                 volume_text(now.bytes), volume_text(now.all_bytes));
  text += rate_text(files, "files") + rate_text(bytes, "B");
  // The bytes determine the time for large files, the number for small ones: whichever is longer.
  const double by_files = static_cast<double>(now.all_files - now.files) / files;
  const double by_bytes = bytes > 0 ? static_cast<double>(now.all_bytes - now.bytes) / bytes : 0;
  return text + left_text(std::max(by_files, by_bytes));
}

ExitStatus read_archive(const ArchiveTask& task, const std::vector<ListedFile>& files,
                        archive::Summary& summary, Host& host) {
  return ArchiveRun(task, summary, host).run(files);
}

}  // namespace biss::verbs
