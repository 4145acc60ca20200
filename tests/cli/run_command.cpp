#include "tests/cli/run_command.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <stdexcept>

extern char** environ;

namespace biss::verbs {

namespace {

// Runs the command, with the words of another program before it.
Outcome run_program(const std::vector<std::string>& before,
                    const std::vector<std::string>& arguments,
                    const std::filesystem::path& input = "/dev/null") {
  const Folder folder;
  const pid_t child = start(Words(before) + Words{BISS_COMMAND} + arguments, input,
                            folder.path("out"), folder.path("err"));
  Outcome outcome;
  int status = 0;
  if (child == -1 || waitpid(child, &status, 0) != child) return outcome;
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  outcome.out = content_of(folder.path("out"));
  outcome.err = content_of(folder.path("err"));
  return outcome;
}

}  // namespace

pid_t start(std::vector<std::string> words, const std::string& input, const std::string& out,
            const std::string& err) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  constexpr int flags = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, input.c_str(), O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, out.c_str(), flags, 0600);
  posix_spawn_file_actions_addopen(&actions, 2, err.c_str(), flags, 0600);
  // These tests may run in the background, where signals of the terminal are ignored.
  sigset_t usual;
  sigemptyset(&usual);
  for (const int number : {SIGINT, SIGHUP, SIGTERM, SIGQUIT}) sigaddset(&usual, number);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setsigdefault(&attributes, &usual);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  pid_t child = -1;
  const int failed = posix_spawnp(&child, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return failed == 0 ? child : -1;
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t from = 0;
  for (;;) {
    const std::size_t end = text.find(separator, from);
    parts.push_back(text.substr(from, end - from));
    if (end == std::string::npos) return parts;
    from = end + 1;
  }
}

Outcome run(const std::vector<std::string>& arguments, const std::filesystem::path& input) {
  return run_program({}, arguments, input);
}

Outcome ok(Outcome outcome) {
  if (outcome.status != 0) {
    throw std::runtime_error(fmt::format("status {}: {}", outcome.status, outcome.err));
  }
  return outcome;
}

Outcome run_measured(const std::vector<std::string>& arguments) {
  constexpr const char* script =
      "import os, sys\n"
      "child = os.posix_spawn(sys.argv[2], sys.argv[2:], os.environ)\n"
      "_, status, usage = os.wait4(child, 0)\n"
      "with open(sys.argv[1], 'w') as peak: peak.write(str(usage.ru_maxrss))\n"
      "code = os.waitstatus_to_exitcode(status)\n"
      "sys.exit(code if code >= 0 else 128 - code)\n";
  const Folder folder;
  const std::string peak = folder.path("peak");
  Outcome outcome = run_program({"python3", "-c", script, peak}, arguments);
  outcome.peak_kib = std::stol(content_of(peak));
  return outcome;
}

Outcome run_limited(const std::string& limit, const std::vector<std::string>& arguments) {
  return run_program({"sh", "-c", "ulimit " + limit + "; exec \"$@\"", "sh"}, arguments);
}

Outcome run_for(std::chrono::microseconds time, const std::string& signal,
                const std::vector<std::string>& arguments) {
  return run_program({"timeout", "--foreground", "--preserve-status", "-s", signal,
                      fmt::format("{:f}", std::chrono::duration<double>(time).count())},
                     arguments);
}

std::vector<Row> rows_of(std::string_view csv) {
  std::istringstream text{std::string(csv)};
  std::string line;
  std::getline(text, line);
  const std::vector<std::string> names = split(line, ',');
  std::vector<Row> rows;
  while (std::getline(text, line)) {
    const std::vector<std::string> cells = split(line, ',');
    Row& row = rows.emplace_back();
    for (std::size_t i = 0; i < names.size() && i < cells.size(); ++i) row[names[i]] = cells[i];
  }
  return rows;
}

std::vector<wire::Edge> edges_of(const std::string& capture) {
  std::vector<wire::Edge> edges;
  std::array<std::string, 2> levels;
  for (const Row& row : rows_of(content_of(capture))) {
    const Picoseconds time{std::llround(std::stod(row.at("time_ns")) * 1e3)};
    for (const wire::LineIndex line : {0U, 1U}) {
      const std::string& level = row.at(line == 0 ? "MA" : "SLO");
      if (level.empty() || level == levels.at(line)) continue;
      levels.at(line) = level;
      edges.push_back({time, line, level == "1" ? wire::Level::high : wire::Level::low});
    }
  }
  return edges;
}

void expect_truth(const std::vector<Row>& rows, const std::vector<Row>& truth) {
  ASSERT_EQ(rows.size(), truth.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].at("status"), "ok") << i;
    EXPECT_EQ(rows[i].at("position"), truth[i].at("position")) << i;
  }
}

std::string rewritten(const Folder& folder, const std::string& name, const std::string& capture,
                      const std::function<void(Row&)>& change) {
  std::string text = "time_ns,MA,SLO\n";
  for (Row row : rows_of(content_of(capture))) {
    change(row);
    text += row["time_ns"] + "," + row["MA"] + "," + row["SLO"] + "\n";
  }
  return folder.file(name, text);
}

std::string one_line(const Folder& folder, const std::string& name, const std::string& line,
                     const std::string& capture, const std::string& column) {
  std::string text = "time_ns," + column + "\n";
  for (const Row& row : rows_of(content_of(capture))) {
    text += row.at("time_ns") + "," + row.at(line) + "\n";
  }
  return folder.file(name, text);
}

std::string joined(const Folder& folder, const std::string& first, const std::string& second) {
  const std::string begin = content_of(first);
  const double later = std::stod(rows_of(begin).back().at("time_ns")) + 200'000;
  const std::string end = content_of(rewritten(folder, "later.csv", second, [&](Row& row) {
    row["time_ns"] = std::to_string(std::stod(row["time_ns"]) + later);
  }));
  return folder.file("joined.csv", begin + end.substr(end.find('\n') + 1));
}

}  // namespace biss::verbs
