#include "tests/cli/run_command.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <stdexcept>

extern char** environ;

namespace biss::verbs {

namespace {

Outcome run_program(std::vector<std::string> words, const std::filesystem::path& input) {
  const Folder folder;
  const std::string out = folder.path("out");
  const std::string err = folder.path("err");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  constexpr int flags = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, input.c_str(), O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, out.c_str(), flags, 0600);
  posix_spawn_file_actions_addopen(&actions, 2, err.c_str(), flags, 0600);
  pid_t child = -1;
  const int failed = posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  Outcome outcome;
  if (failed != 0) return outcome;
  int status = 0;
  if (waitpid(child, &status, 0) != child) return outcome;
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  outcome.out = content_of(out);
  outcome.err = content_of(err);
  return outcome;
}

}  // namespace

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
  return run_program(Words{BISS_COMMAND} + arguments, input);
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
  Outcome outcome =
      run_program(Words{"python3", "-c", script, peak, BISS_COMMAND} + arguments, "/dev/null");
  outcome.peak_kib = std::stol(content_of(peak));
  return outcome;
}

Folder::Folder() {
  std::string name = (std::filesystem::temp_directory_path() / "biss-cli-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) std::abort();
  folder_ = name;
}

Folder::~Folder() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

std::string Folder::file(const std::string& name, std::string_view content) const {
  std::ofstream(folder_ / name, std::ios::binary) << content;
  return path(name);
}

std::size_t Folder::files() const {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_)) ++count;
  return count;
}

std::string content_of(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
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

}  // namespace biss::verbs
