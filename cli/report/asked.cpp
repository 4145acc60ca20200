#include "cli/report/asked.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>

extern char** environ;

namespace biss::cli {

namespace {

// Rules and causes are few; the rest is no answer of these verbs.
constexpr std::size_t answer_max = std::size_t{1} << 20U;

using StreamHandle = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

StreamHandle temporary_stream() { return {std::tmpfile(), std::fclose}; }

std::string text_in(std::FILE* stream) {
  std::rewind(stream);
  std::string text(answer_max, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), stream));
  return text;
}

}  // namespace

tl::expected<nlohmann::json, VerbError> ask_command(const std::vector<std::string>& words) {
  std::vector<std::string> texts{"biss"};
  texts.insert(texts.end(), words.begin(), words.end());
  std::vector<char*> argv;
  for (std::string& text : texts) argv.push_back(text.data());
  argv.push_back(nullptr);
  const auto wrong = [&](int cause) {
    return tl::unexpected(VerbError{
        ExitStatus::io, fmt::format("biss {}: cannot be run: {}", words[0], std::strerror(cause))});
  };
  const StreamHandle out = temporary_stream();
  const StreamHandle err = temporary_stream();
  if (!out || !err) return wrong(errno);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, fileno(out.get()), 1);
  posix_spawn_file_actions_adddup2(&actions, fileno(err.get()), 2);
  pid_t child = -1;
  const int failed = posix_spawn(&child, "/proc/self/exe", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) return wrong(failed);
  int status = 0;
  while (waitpid(child, &status, 0) != child) {
    if (errno != EINTR) return wrong(errno);
  }
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : static_cast<int>(ExitStatus::io);
  return nlohmann::json{{"status", code}, {"out", text_in(out.get())}, {"err", text_in(err.get())}};
}

}  // namespace biss::cli
