// `biss archive`: many captures in one pass, and one summary of all.
#include "verbs/archive/archive.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <climits>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <utility>

#include "verbs/common/files.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/program.hpp"
#include "verbs/common/verb.hpp"

namespace biss::verbs {

namespace {

struct ArchiveOptions {
  ArchiveTask task;
  std::string list;
  SummaryOptions summary;
  std::vector<std::string> parts;
  std::optional<Verb> read;
  std::optional<Verb> merge;
};

// The options that decide how a file is read, in the order of their names.
std::vector<std::string> settings_of(const Verb& verb) {
  std::vector<std::string> settings;
  for (const Option* option : verb.given_options()) {
    if (option->scope == Scope::command) continue;
    settings.push_back(fmt::format("{} {}", option->name(), fmt::join(option->given, " ")));
  }
  std::sort(settings.begin(), settings.end());
  for (std::string& setting : settings) setting = archive::utf8_text(setting);
  return settings;
}

// The journal is next to the output; nothing if the output is not a file.
std::string journal_of(const std::string& output) {
  if (output.empty() || output == "-") return {};
  const std::string target = follow_links(output);
  struct stat about {};
  const bool exists = ::stat(target.c_str(), &about) == 0;
  if (target.empty() || names_a_descriptor(target) || (exists && !S_ISREG(about.st_mode))) {
    return {};
  }
  return target + ".journal";
}

// The lines of a file that names files. Line ends may be LF or CRLF, and UTF-8's byte-order mark may
// come first. A device may have no end, so lines and their number have limits.
std::vector<std::string> read_list(const std::string& path) {
  constexpr std::size_t most_lines = 10'000'000;
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  std::ifstream file(path, std::ios::binary);
  const auto fail = [&](const std::string& why) { throw wrong_file("{}: {}", path, why); };
  if (!file.is_open()) fail("cannot open it");
  std::vector<std::string> lines;
  std::array<char, PATH_MAX + 2> buffer{};
  std::size_t number = 1;
  for (; file.getline(buffer.data(), buffer.size()); ++number) {
    if (number > most_lines) {
      fail(fmt::format("more than {} lines; give several lists, and merge their summaries",
                       most_lines));
    }
    // The count has the line feed, except at the end of the file.
    std::string_view line(buffer.data(),
                          static_cast<std::size_t>(file.gcount()) - (file.eof() ? 0U : 1U));
    if (number == 1 && line.starts_with(mark)) line.remove_prefix(mark.size());
    if (line.ends_with('\r')) line.remove_suffix(1);
    const auto has = [line](char c) { return line.find(c) != std::string_view::npos; };
    if (has('\0')) {
      fail(fmt::format("line {} has a zero byte; write a text in UTF-8, one path a line", number));
    }
    if (has('\r') && !std::filesystem::exists(line)) {
      fail(fmt::format("line {} has a CR inside; end each line in LF or CRLF", number));
    }
    if (!line.empty()) lines.emplace_back(line);
  }
  if (file.bad()) fail("cannot read it");
  if (!file.eof()) {
    fail(
        fmt::format("line {} has more than {} bytes, more than any path has; write one path a line",
                    number, PATH_MAX));
  }
  return lines;
}

// One line: the output would replace one of the files; else empty.
std::string replaced_file(const std::string& output, const std::vector<archive::ListedFile>& files,
                          Host& host) {
  archive::FileStamp stamp;
  if (output.empty() || output == "-" || !archive::read_stamp(output, stamp)) return {};
  for (const archive::ListedFile& file : files) {
    if (!file.cause.empty() || file.stamp != stamp) continue;
    std::string conflict = file_conflict(
        {{"--output", output, FileUse::write}, {"the file to be read", file.path, FileUse::read}},
        host);
    if (!conflict.empty()) return conflict;
  }
  return {};
}

ExitStatus run_read(const ArchiveOptions& options, Host& host) {
  const std::vector<std::string>& paths = options.task.capture.files;
  std::vector<std::string> listed;
  if (!options.list.empty()) listed = read_list(options.list);
  if (paths.empty() && listed.empty()) {
    throw wrong_usage("no folder given; name one, or --files-from");
  }
  const auto names_stdin = [](const std::vector<std::string>& names) {
    return std::find(names.begin(), names.end(), "-") != names.end();
  };
  if (names_stdin(paths) || names_stdin(listed)) {
    throw wrong_usage("standard input is not a folder; for a file of that name give ./-");
  }
  // The options are wrong for each file, or for none.
  CaptureArguments checked = options.task.capture;
  checked.files = {"any"};
  if (const ExitStatus status = DecodedCapture(host).open(checked); status != ExitStatus::done) {
    return status;
  }
  const auto files = value_or_fail(archive::list_files(paths, listed), ExitStatus::io);
  fail_if(replaced_file(options.summary.output, files, host));
  ArchiveTask task = options.task;
  // Figures of different programs do not add up.
  task.setup = {program_text(), settings_of(*options.read)};
  task.journal = journal_of(options.summary.output);
  archive::Summary summary = read_archive(task, files, host);
  return show_summary(summary, options.summary, host);
}

ExitStatus run_merge(const ArchiveOptions& options, Host& host) {
  std::vector<archive::NamedSummary> parts;
  for (const std::string& path : options.parts) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw wrong_file("{}: cannot open it", path);
    auto part = archive::read_summary(file);
    if (!part) {
      throw wrong_file("{}: not a usable summary: {}", path, part.error());
    }
    parts.emplace_back(path, std::move(*part));
  }
  archive::Summary sum = value_or_fail(archive::merge(std::move(parts)), ExitStatus::io);
  const ExitStatus status = show_summary(sum, options.summary, host);
  if (status != ExitStatus::done || sum.parts.complete()) return status;
  return host.fail(ExitStatus::data_failed,
                   fmt::format("shards are missing: {} of {}; run them, and merge all again",
                               sum.parts.missing(), sum.parts.count));
}

void add_summary_options(Verb verb, SummaryOptions& summary) {
  add_count_option(verb.scope(Scope::command), "--worst", into(summary.worst),
                   "Rows of the table on standard output, the worst files first; 20 by default");
  add_to_option(verb, summary.to,
                {report::Format::table, report::Format::csv, report::Format::jsonl}, false);
}

}  // namespace

void add_archive(Command& command) {
  const auto options = std::make_shared<ArchiveOptions>();
  Verb verb = command.add_verb(
      {.name = "archive",
       .purpose = "Read all captures in folders, and write one summary, the worst files first",
       .examples = {"biss archive captures -o summary.json",
                    "biss archive captures --shard 1/2 -o shard1.json",
                    "biss archive merge shard1.json shard2.json -o summary.json"}},
      [options](Host& host) {
        return options->merge->parsed() ? run_merge(*options, host) : run_read(*options, host);
      });
  verb.add_option("DIR", options->task.capture.files,
                  "Folders with captures of any format, and the folders in them; also single files")
      .file(FileUse::read);
  add_reading_options(verb, options->task.capture);
  const Verb own = verb.scope(Scope::command);
  own.add_option("--files-from", options->list,
                 "Also read the files and folders that this file names, one a line")
      .type_name("FILE")
      .file(FileUse::read);
  add_shard_option(verb, options->task.shard, "Read only every N-th file, from the K-th on");
  add_count_option(own, "--threads", into(options->task.threads),
                   "Worker threads; by default one per core. The summary does not depend on it",
                   1024);
  add_output_option(
      verb, options->summary.output,
      "The summary as JSON. FILE.journal keeps the results so far: after an interruption "
      "the same command continues");
  add_summary_options(verb, options->summary);
  Verb merge =
      verb.add_verb({.name = "merge",
                     .purpose = "Add up the summaries of shards, or of different folders",
                     .examples = {"biss archive merge shard1.json shard2.json -o summary.json"}});
  merge.add_option("FILE", options->parts, "Summaries written by biss archive")
      .required()
      .file(FileUse::read);
  add_output_option(merge, options->summary.output, "The summary as JSON");
  add_summary_options(merge, options->summary);
  options->read = verb;
  options->merge = merge;
}

}  // namespace biss::verbs
